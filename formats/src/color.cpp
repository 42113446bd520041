#include "pvol/formats/color.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "file/grid_names.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"
#include "vdb/vdb_calls.h"

namespace pvol::formats {
namespace {

using detail::listed;
using detail::same_name;

constexpr std::string_view kUsualNames[] = {"Cd", "color", "colour", "albedo"};

bool has_part(std::span<const GridEntry> grids, const std::string& name) {
  return std::ranges::any_of(grids, [&](const GridEntry& g) { return same_name(g.name, name); });
}

LoadedColor read_parts(const std::filesystem::path& file, const std::string& name, bool strict) {
  const std::vector<GridEntry> grids = grids_of(file);
  if (!has_colors(grids, name)) {
    throw Error(
        fmt::format("{}: holds no colours called '{}'; expected three grids '{}.x', '{}.y' and "
                    "'{}.z'; the file has: {}",
                    file.string(), name, name, name, name, listed(grids)));
  }
  LoadedColor loaded;
  const std::vector<std::string> parts = color_parts(name);
  for (std::size_t c = 0; c < 3; ++c) {
    LoadedGrid part = load_grid(file, {parts[c], strict});
    VoxelGrid& to = loaded.grid.channels[c];
    to = std::move(part.grid);
    to.name = name;
    if (!(to.index_to_world == loaded.grid.index_to_world())) {
      throw Error(
          fmt::format("{}: the grids {} and {} lie on different lattices; fit the cloud again",
                      file.string(), parts[0], parts[c]));
    }
    loaded.report.active = std::max(loaded.report.active, part.report.active);
    loaded.report.largest = std::max(loaded.report.largest, part.report.largest);
  }
  loaded.report.grid = name;
  loaded.report.type = "colours";
  if (has_part(grids, parts[3])) {
    const VoxelGrid black = load_grid(file, {parts[3], strict}).grid;
    loaded.grid.known = known_of(loaded.grid.channels, &black);
  } else {
    loaded.grid.known = known_of(loaded.grid.channels, nullptr);
  }
  loaded.grid.known.name = name;
  return loaded;
}

}  // namespace

std::vector<std::string> color_parts(const std::string& name) {
  return {name + ".x", name + ".y", name + ".z", name + ".black"};
}

bool has_colors(std::span<const GridEntry> grids, const std::string& name) {
  const auto is_vector = [&](const GridEntry& g) {
    return same_name(g.name, name) && (g.type.starts_with("vec3s") || g.type.starts_with("vec3d"));
  };
  if (std::ranges::any_of(grids, is_vector)) return true;
  const std::vector<std::string> parts = color_parts(name);
  return std::all_of(parts.begin(), parts.begin() + 3,
                     [&](const std::string& part) { return has_part(grids, part); });
}

std::string usual_color_grid(std::span<const GridEntry> grids) {
  for (const std::string_view usual : kUsualNames) {
    for (const GridEntry& g : grids) {
      const std::string name =
          g.name.ends_with(".x") ? g.name.substr(0, g.name.size() - 2) : g.name;
      if (same_name(name, usual) && has_colors(grids, name)) return name;
    }
  }
  return {};
}

LoadedColor read_color(const std::filesystem::path& file, const std::string& name, bool strict) {
  const std::string kind = ending(file);
  if (kind == ".vdb") return detail::vdb_calls(file).read_color(file, name, strict);
  if (kind == ".pvol") return read_parts(file, name, strict);
  throw Error(file.string() +
              ": colours are read from .vdb and .pvol files; convert it to .vdb, or leave them out "
              "with medium.albedo_field.grid = \"none\"");
}

}  // namespace pvol::formats
