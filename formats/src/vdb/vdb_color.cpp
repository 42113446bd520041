#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "vdb/vdb_calls.h"
#include "vdb/vdb_load.h"
#include "vdb/vdb_vectors.h"

namespace pvol::formats::detail {
namespace {

/// What became of components.
struct ColorCounts {
  std::uint64_t active = 0, non_finite = 0, negative = 0, above = 0;
  float largest = 0;
};

/// The component of an albedo that `samples` samples of value v are taken for.
float to_share(float v, std::uint64_t samples, ColorCounts& counts) {
  counts.active += samples;
  if (!std::isfinite(v)) {
    counts.non_finite += samples;
    return 0;
  }
  if (v < 0) counts.negative += samples;
  if (v > 1) counts.above += samples;
  const float share = v > 0 ? std::min(v, 1.0f) : 0.0f;
  counts.largest = std::max(counts.largest, share);
  return share;
}

void finish(const std::filesystem::path& path, const ColorCounts& counts, bool strict,
            GridReport& report) {
  report.active = counts.active;
  report.non_finite = counts.non_finite;
  report.negative = counts.negative;
  report.largest = counts.largest;
  const auto warn = [&](std::uint64_t count, const char* what) {
    if (count == 0) return;
    report.warnings.push_back(fmt::format("grid '{}': {} of {} components of colours {}",
                                          printable(report.grid), count, counts.active, what));
  };
  warn(counts.non_finite, "are not finite; they are taken as 0");
  warn(counts.negative, "are negative; they are taken as 0");
  warn(counts.above, "are above 1; they are taken as 1");
  if (counts.active == 0) {
    report.warnings.push_back(
        fmt::format("grid '{}': no voxel has a colour", printable(report.grid)));
  }
  if (!strict || report.warnings.empty()) return;
  throw Error(fmt::format("{}: is refused (strict): {}", path.string(), report.warnings.front()));
}

}  // namespace

LoadedColor read_vdb_color(const std::filesystem::path& path, const std::string& name,
                           bool strict) try {
  ByteSource source(path);
  const VdbFile file = inspect_vdb(source);
  const VdbGrid* const chosen = find_grid(file, name, is_vector);
  if (chosen == nullptr) {
    throw Error(fmt::format("{}: no grid of vectors is called '{}'; the file has: {}",
                            path.string(), printable(name), list_grids(choices(file))));
  }
  LoadedColor loaded;
  loaded.report.grid = chosen->name;
  loaded.report.type = value_type(*chosen);
  const openvdb::GridBase::Ptr grid = load_vdb_grid(source, file, *chosen);
  ColorCounts counts;
  VectorCollector values(
      [&](float v, std::uint64_t samples) { return to_share(v, samples, counts); });
  values.add(grid, 0);
  const std::string& called = chosen->base.empty() ? chosen->name : chosen->base;
  std::array<VoxelGrid, 4> grids =
      std::move(values).take(affine_map(source, *chosen, grid->transform()), called);
  for (std::size_t c = 0; c < 3; ++c) loaded.grid.channels[c] = std::move(grids[c]);
  loaded.grid.known = std::move(grids[3]);
  finish(path, counts, strict, loaded.report);
  return loaded;
} catch (const std::bad_alloc&) {
  throw Error(path.string() + ": not enough memory to load its colours");
}

}  // namespace pvol::formats::detail
