// A cloud from memory, its bounds, and transmittance through it, with the installed library alone.
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "pvol/render/volume.h"
#include "pvol/track/transmittance.h"
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
  pvol::Scene scene;
  scene.medium.extinction = 0.5;
  const pvol::Volume volume = pvol::make_volume(ball, pyramid, scene);

  // The exact extinction where a tracker asks for it; the ray runs along x through the centre.
  const pvol::PlainField extinction{pvol::BrickExtinction<pvol::Interpolation::trilinear>{
      volume.field, volume.octree, volume.extinction}};
  const pvol::Vec3d entry = volume.world_to_cells.point({0.5, 4, 4});
  const pvol::Vec3f direction(volume.world_to_cells.vector({1, 0, 0}));

  constexpr int kRays = 100000;
  double sum = 0;
  for (int i = 0; i < kRays; ++i) {
    pvol::Rng rng(/*seed=*/1, /*stream=*/std::uint64_t(i), /*sample=*/0);
    pvol::Cursor cursor = pvol::make_cursor(volume.octree, entry);
    pvol::Walk walk(volume.octree, cursor, pvol::lanes(direction));
    pvol::NoTally none;
    sum += double(pvol::transmittance<pvol::Transmittance::ratio, pvol::Tracker::delta>(
        walk, extinction, rng, none));
  }
  const double estimate = sum / kRays, exact = std::exp(-0.5 * 3);  // the samples add up to 3
  std::printf("pvol %s: transmittance %.4f, exactly %.4f\n", PVOL_VERSION, estimate, exact);
  return std::abs(estimate - exact) < 0.005 ? 0 : 1;
}
