// Makes the clouds of hundreds of millions of voxels that no file here holds.
//
//   make_large_cloud CLOUD FACTOR OUT.pvol
//
// CLOUD is sampled FACTOR times as densely along each axis, and noise as fine as its new voxels
// erodes its edges, so that they are as rough as those of a cloud of that size. OUT.pvol is not
// compressed: renders use its samples where they lie. It takes 2 kB of memory for each 8^3 voxels.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <unordered_set>

#include "pvol/density/noise.h"
#include "pvol/embed.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/pvol_file.h"

namespace {

using namespace pvol;

/// Where a grid has samples, by its bricks.
class Occupied {
 public:
  explicit Occupied(const VoxelGrid& grid) {
    for (const Brick& b : grid.bricks) keys_.insert(key(b.origin));
    for (const Tile& t : grid.tiles) {
      for_bricks(t.origin, t.origin + Vec3i(t.edge - 1), [&](Vec3i at) { keys_.insert(key(at)); });
    }
  }

  /// Whether a brick has a sample in the box.
  [[nodiscard]] bool meets(Vec3i lo, Vec3i hi) const {
    bool any = false;
    for_bricks(lo, hi, [&](Vec3i at) { any = any || keys_.contains(key(at)); });
    return any;
  }

 private:
  static std::uint64_t key(Vec3i at) {
    const auto part = [](int v) { return std::uint64_t(std::uint32_t(v >> 3)) & 0x1fffff; };
    return part(at.x) << 42 | part(at.y) << 21 | part(at.z);
  }
  template <class Visit>
  static void for_bricks(Vec3i lo, Vec3i hi, const Visit& visit) {
    for (int x = lo.x & -kBrickEdge; x <= hi.x; x += kBrickEdge) {
      for (int y = lo.y & -kBrickEdge; y <= hi.y; y += kBrickEdge) {
        for (int z = lo.z & -kBrickEdge; z <= hi.z; z += kBrickEdge) visit(Vec3i(x, y, z));
      }
    }
  }

  std::unordered_set<std::uint64_t> keys_;
};

/// The least and the most lattice points with samples.
std::pair<Vec3i, Vec3i> extent_of(const VoxelGrid& grid) {
  Vec3i lo(1 << 30), hi(-(1 << 30));
  for (const Brick& b : grid.bricks) {
    lo = min(lo, b.origin), hi = max(hi, b.origin + Vec3i(kBrickEdge));
  }
  for (const Tile& t : grid.tiles) lo = min(lo, t.origin), hi = max(hi, t.origin + Vec3i(t.edge));
  return {lo, hi};
}

VoxelGrid refine(const VoxelGrid& from, int factor) {
  VoxelGrid at_cells = from;  // so that world points are index points
  at_cells.index_to_world = {};
  const Volume source = make_volume(at_cells, {.extinction = 1}, VolumeOptions{});
  const Occupied occupied(from);
  const Fbm noise{.seed = 33, .cell = 8.0 / factor, .octaves = 3, .gain = 0.6, .billow = true};
  const FillBrick fill = [&](Vec3i origin, float* values) {
    const auto floor_to_source = [&](int v) {
      return v >= 0 ? v / factor : -((factor - 1 - v) / factor);
    };
    Vec3i lo, hi;
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = floor_to_source(origin[axis]);
      hi[axis] = floor_to_source(origin[axis] + kBrickEdge - 1) + 1;
    }
    if (!occupied.meets(lo, hi)) return;
    for (int i = 0; i < kBrickSamples; ++i) {
      const Vec3d at = Vec3d(origin + Vec3i(i >> 6, i >> 3 & 7, i & 7)) / double(factor);
      const float density = density_at(source, at);
      if (!(density > 0)) continue;
      // Edges are eroded, and the inside stays as it is.
      constexpr double kEroded = 0.3;
      const double edge = std::max(0.0, 1 - double(density) / kEroded);
      const double left = double(density) - kEroded * edge * fbm(noise, at);
      values[i] = left > 0 ? float(left) : 0;
    }
  };
  const auto [lo, hi] = extent_of(from);
  VoxelGrid grid =
      make_grid(lo * factor, hi * factor, fill, from.index_to_world * scaling(Vec3d(1.0 / factor)));
  grid.name = from.name;
  return grid;
}

std::uint64_t count_active(const VoxelGrid& grid) {
  std::uint64_t n = 0;
  for (const Brick& b : grid.bricks) {
    n += std::uint64_t(kBrickSamples - std::count(b.values, b.values + kBrickSamples, 0.0f));
  }
  return n;
}

void run(const std::string& from, int factor, const std::string& to) {
  formats::PvolFile file;
  {
    const formats::LoadedGrid loaded = formats::load_grid(from);
    file.density = refine(loaded.grid, factor);
  }
  file.pyramid = formats::build_bounds(*file.density, from);
  file.metadata.grid_name = file.density->name;
  file.metadata.index_to_world = file.density->index_to_world;
  file.metadata.written_by = "make_large_cloud";
  const formats::PvolSizes sizes = formats::write_pvol(to, file, formats::Compression::none);
  std::printf("%s: %llu active voxels in %zu bricks, %.2f GB\n", to.c_str(),
              static_cast<unsigned long long>(count_active(*file.density)),
              file.density->bricks.size(), double(sizes.total) / 1e9);
}

}  // namespace

int main(int argc, char** argv) try {
  const int factor = argc == 4 ? std::atoi(argv[2]) : 0;
  if (factor < 1 || factor > 16) {
    std::fputs("usage: make_large_cloud CLOUD FACTOR OUT.pvol\n  FACTOR 1 to 16\n", stderr);
    return 2;
  }
  run(argv[1], factor, argv[3]);
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
