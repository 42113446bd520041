// The samples of a grid as a NanoVDB grid in memory, for comparisons.
#pragma once

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>

#include "pvol/density/voxel_grid.h"

namespace pvol::bench {

using NanoHandle = nanovdb::GridHandle<nanovdb::HostBuffer>;

/// Calls put(lattice point, value) for every sample of the grid that is not 0.
template <class Put>
void for_samples(const VoxelGrid& grid, const Put& put) {
  for (const Brick& b : grid.bricks) {
    for (int i = 0; i < kBrickSamples; ++i) {
      if (b.values[i] != 0) put(b.origin + Vec3i(i >> 6, i >> 3 & 7, i & 7), b.values[i]);
    }
  }
  for (const Tile& t : grid.tiles) {
    for (int i = 0; i < t.edge; ++i) {
      for (int j = 0; j < t.edge; ++j) {
        for (int k = 0; k < t.edge; ++k) put(t.origin + Vec3i(i, j, k), t.value);
      }
    }
  }
}

/// In index space: without the grid's map.
[[nodiscard]] inline NanoHandle make_nano(const VoxelGrid& grid) {
  nanovdb::GridBuilder<float> builder(0.0f);
  auto accessor = builder.getAccessor();
  for_samples(grid,
              [&](Vec3i at, float v) { accessor.setValue(nanovdb::Coord(at.x, at.y, at.z), v); });
  return builder.getHandle<>();
}

}  // namespace pvol::bench
