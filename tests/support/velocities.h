// Velocities for tests, from functions of places on a lattice.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "pvol/density/velocity_grid.h"

namespace pvol::test {

/// velocity(p) at each lattice point p of the bricks that hold lo <= p < hi.
[[nodiscard]] inline VelocityGrid make_velocity(Vec3i lo, Vec3i hi,
                                                const std::function<Vec3d(Vec3i)>& velocity,
                                                const Affine& index_to_world = {}) {
  auto samples = std::make_shared<std::vector<std::vector<float>>>();
  VelocityGrid grid;
  for (VoxelGrid& g : grid.along) g.index_to_world = index_to_world;
  for (Vec3i o = Vec3i(lo.x & ~7, 0, 0); o.x < hi.x; o.x += 8) {
    for (o.y = lo.y & ~7; o.y < hi.y; o.y += 8) {
      for (o.z = lo.z & ~7; o.z < hi.z; o.z += 8) {
        for (int c = 0; c < 3; ++c) {
          std::vector<float>& values = samples->emplace_back(kBrickSamples);
          for (int i = 0; i < kBrickSamples; ++i) {
            values[std::size_t(i)] = float(velocity(o + Vec3i(i >> 6, i >> 3 & 7, i & 7))[c]);
          }
          grid.along[std::size_t(c)].bricks.push_back({o, values.data()});
        }
      }
    }
  }
  for (VoxelGrid& g : grid.along) g.owner = samples;
  return grid;
}

/// Trilinear between functions of lattice points: an oracle.
[[nodiscard]] inline double trilinear(const std::function<double(Vec3i)>& at, Vec3d p) {
  const Vec3i cell{int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))};
  const Vec3d f = p - Vec3d(cell);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3i corner(i & 1, i >> 1 & 1, i >> 2);
    const double weight =
        (corner.x ? f.x : 1 - f.x) * (corner.y ? f.y : 1 - f.y) * (corner.z ? f.z : 1 - f.z);
    if (weight > 0) sum += weight * at(cell + corner);
  }
  return sum;
}

}  // namespace pvol::test
