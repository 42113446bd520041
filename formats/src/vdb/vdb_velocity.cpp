// Vector grids, or three grids of numbers, as the components of velocities.
#include <fmt/format.h>

#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "file/grid_choice.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "vdb/vdb_calls.h"
#include "vdb/vdb_load.h"
#include "vdb/vdb_vectors.h"

namespace pvol::formats {
namespace {

using detail::ByteSource;
using detail::find_grid;
using detail::is_number;
using detail::is_vector;
using detail::VdbFile;
using detail::VdbGrid;

/// One grid of vectors, three of numbers, or none.
std::vector<const VdbGrid*> choose(const VdbFile& file, std::string_view name) {
  if (const VdbGrid* grid = find_grid(file, name, is_vector)) return {grid};
  for (const char* between : {".", "_", ""}) {
    std::vector<const VdbGrid*> all;
    for (const char axis : {'x', 'y', 'z'}) {
      all.push_back(find_grid(file, fmt::format("{}{}{}", name, between, axis), is_number));
    }
    if (std::find(all.begin(), all.end(), nullptr) == all.end()) return all;
  }
  return {};
}

LoadedVelocity load(ByteSource& source, const VdbFile& file,
                    const std::vector<const VdbGrid*>& chosen, const std::string& name) {
  LoadedVelocity loaded;
  loaded.name = chosen.size() == 1 ? chosen.front()->name : name;
  std::uint64_t non_finite = 0;
  detail::VectorCollector values([&](float v, std::uint64_t samples) {
    if (std::isfinite(v)) return v;
    non_finite += samples;
    return 0.0f;
  });
  std::optional<Affine> map;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const openvdb::GridBase::Ptr grid = load_vdb_grid(source, file, *chosen[i]);
    const Affine own = detail::affine_map(source, *chosen[i], grid->transform());
    if (map && !(*map == own)) {
      throw Error(
          fmt::format("{}: the grids {} and {} lie on different lattices, as staggered "
                      "velocities do; resample them to one, or to a grid of vectors",
                      source.file().string(), chosen[0]->name, chosen[i]->name));
    }
    map = own;
    values.add(grid, int(i));
  }
  if (chosen.front()->grid_class == "staggered") {
    loaded.warnings.push_back(
        "the velocities are staggered; they are used as if they lay at the voxels' centres, half a "
        "voxel away");
  }
  if (non_finite > 0) {
    loaded.warnings.push_back(
        fmt::format("{} components of velocities are not finite; they are taken as 0", non_finite));
  }
  std::array<VoxelGrid, 4> grids = std::move(values).take(*map, loaded.name);
  for (std::size_t c = 0; c < 3; ++c) loaded.grid.along[c] = std::move(grids[c]);
  return loaded;
}

}  // namespace

std::optional<LoadedVelocity> detail::read_vdb_velocity(const std::filesystem::path& path,
                                                        const std::string& name, bool strict) try {
  ByteSource source(path);
  const VdbFile file = inspect_vdb(source);
  std::vector<const VdbGrid*> chosen;
  std::string base = name;
  if (!name.empty()) {
    chosen = choose(file, name);
    if (chosen.empty()) {
      throw Error(
          fmt::format("{}: no grid of vectors is called '{}', nor three of numbers '{}.x', "
                      "'{}.y' and '{}.z'; the file has: {}",
                      path.string(), name, name, name, name, detail::list_grids(choices(file))));
    }
  } else {
    for (const std::string_view usual : kUsualVelocities) {
      if (chosen.empty()) chosen = choose(file, base = usual);
    }
    if (chosen.empty()) return std::nullopt;
  }
  LoadedVelocity loaded = load(source, file, chosen, base);
  if (strict && !loaded.warnings.empty()) {
    throw Error(fmt::format("{}: grid '{}' is refused (strict): {}", path.string(), loaded.name,
                            loaded.warnings.front()));
  }
  return loaded;
} catch (const std::bad_alloc&) {
  throw Error(path.string() + ": not enough memory to load its velocities");
}

}  // namespace pvol::formats
