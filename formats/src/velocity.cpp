#include "pvol/formats/velocity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "file/grid_names.h"
#include "pvol/density/recipe.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/recipe_file.h"
#include "vdb/vdb_calls.h"

namespace pvol::formats {
namespace {

using detail::same_name;

/// Between the name of vectors and x, y or z, where each component is a grid of its own.
constexpr std::array kBetween = {".", "_", ""};

constexpr std::string_view kParts[] = {".x+", ".x-", ".y+", ".y-", ".z+", ".z-"};

/// What stands before the part in a name; "" where it is none of a velocity.
std::string base_of(const std::string& part) {
  for (const std::string_view end : kParts) {
    if (part.ends_with(end)) return part.substr(0, part.size() - end.size());
  }
  return {};
}

/// The name as the file writes it of velocities that it keeps in parts.
std::string find_parts(std::span<const GridEntry> grids, std::string_view name) {
  for (const GridEntry& g : grids) {
    if (const std::string base = base_of(g.name); same_name(base, name)) return base;
  }
  return {};
}

/// Parts of which nothing is above 0 are not in the file.
LoadedVelocity join(const std::filesystem::path& file, const std::string& name,
                    std::span<const GridEntry> grids, bool strict) {
  std::array<VoxelGrid, 6> parts;
  const Affine* map = nullptr;
  const std::vector<std::string> names = velocity_parts(name);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto is_it = [&](const GridEntry& g) { return g.name == names[i]; };
    if (std::ranges::none_of(grids, is_it)) continue;
    parts[i] = load_grid(file, {names[i], strict}).grid;
    if (map != nullptr && !(*map == parts[i].index_to_world)) {
      throw Error(
          fmt::format("{}: the grid {} lies on another lattice than the other parts of "
                      "the velocity; fit the cloud again",
                      file.string(), names[i]));
    }
    map = &parts[i].index_to_world;
  }
  for (VoxelGrid& part : parts) {
    part.name = name;
    part.index_to_world = Affine(*map);
  }
  return {join_parts(parts), name, {}};
}

std::optional<LoadedVelocity> read_pvol_velocity(const std::filesystem::path& file,
                                                 const std::string& name, bool strict) {
  const std::vector<GridEntry> grids = grids_of(file);
  const std::string found = name.empty() ? usual_velocity(grids) : find_parts(grids, name);
  if (!found.empty()) return join(file, found, grids, strict);
  if (name.empty()) return std::nullopt;
  throw Error(
      fmt::format("{}: no velocity is called '{}', which would be grids '{}.x+', '{}.x-' "
                  "and so on; fit the cloud again with --fields {}",
                  file.string(), name, name, name, name));
}

std::optional<LoadedVelocity> sample_recipe(const std::filesystem::path& file,
                                            const std::string& name) {
  const std::optional<Flow> flow = read_flow(file);
  if (!flow) return std::nullopt;
  // Files that are made of it call it v.
  const auto is_it = [&](std::string_view usual) { return same_name(name, usual); };
  if (!name.empty() && !is_it("flow") && std::ranges::none_of(kUsualVelocities, is_it)) {
    throw Error(fmt::format("{}: no velocity is called '{}'; a recipe has one, its flow, called v",
                            file.string(), name));
  }
  const Recipe recipe = read_recipe(file);
  const Box box = support(recipe);
  // At most 128 along a side, margins included: 25 MB.
  const double voxel = std::max(4 * recipe.voxel, max_component(box.extent()) / 64);
  return LoadedVelocity{sample_flow(*flow, box, voxel), "flow", {}};
}

}  // namespace

std::vector<std::string> velocity_parts(const std::string& name) {
  std::vector<std::string> names;
  for (const std::string_view end : kParts) names.push_back(name + std::string(end));
  return names;
}

bool has_velocity(std::span<const GridEntry> grids, const std::string& name) {
  const auto has = [&](const std::string& of, bool vectors) {
    return std::ranges::any_of(grids, [&](const GridEntry& g) {
      return same_name(g.name, of) && g.type.starts_with("vec3") == vectors;
    });
  };
  if (has(name, true) || !find_parts(grids, name).empty()) return true;
  return std::ranges::any_of(kBetween, [&](const char* between) {
    const std::string stem = name + between;
    return has(stem + "x", false) && has(stem + "y", false) && has(stem + "z", false);
  });
}

bool is_component(const std::string& grid, const std::string& vectors) {
  return std::ranges::any_of(kBetween, [&](const char* between) {
    return std::ranges::any_of(std::string_view("xyz"), [&](char axis) {
      return same_name(grid, vectors + between + axis);
    });
  });
}

std::string usual_velocity(std::span<const GridEntry> grids) {
  for (const std::string_view usual : kUsualVelocities) {
    if (const std::string parts = find_parts(grids, usual); !parts.empty()) return parts;
    if (has_velocity(grids, std::string(usual))) return std::string(usual);
  }
  return {};
}

std::optional<LoadedVelocity> read_velocity(const std::filesystem::path& file,
                                            const std::string& name, bool strict) {
  const std::string kind = ending(file);
  if (kind == ".vdb") return detail::vdb_calls(file).read_velocity(file, name, strict);
  if (kind == ".pvol") return read_pvol_velocity(file, name, strict);
  if (kind == ".toml") return sample_recipe(file, name);
  throw Error(file.string() +
              ": velocities are read from .vdb and .pvol files and from recipes only; name one "
              "with medium.motion.file");
}

}  // namespace pvol::formats
