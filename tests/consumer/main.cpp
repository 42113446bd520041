// A cloud from memory and its bounds, through the installed library alone.
#include <cstdio>
#include <memory>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/version.h"

namespace {

/// A ball of radius 3 in one brick: density 1 at the centre, falling to 0 at the surface.
pvol::VoxelGrid make_ball() {
  const auto samples = std::make_shared<std::vector<float>>(pvol::kBrickSamples);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      for (int k = 0; k < 8; ++k) {
        const double r = pvol::length(pvol::Vec3d(i - 4, j - 4, k - 4));
        (*samples)[std::size_t((i * 8 + j) * 8 + k)] = float(std::max(0.0, 1 - r / 3));
      }
    }
  }
  pvol::VoxelGrid grid;
  grid.bricks.push_back({{0, 0, 0}, samples->data()});
  grid.owner = samples;
  return grid;
}

}  // namespace

int main() {
  const pvol::VoxelGrid ball = make_ball();
  const pvol::Pyramid pyramid = pvol::build_pyramid(ball);
  const pvol::PyramidNode& root = pyramid.levels.back().front();
  std::printf("pvol %s: %zu leaf, density in [%g, %g]\n", PVOL_VERSION, pyramid.levels[0].size(),
              double(root.lo), double(root.hi));
  return root.lo == 0 && root.hi == 1 ? 0 : 1;
}
