#include "pvol/render/estimators.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pvol {

BoundIntegrals integrate_bounds(const Octree& octree) {
  BoundIntegrals sum;
  for (const Octree::Node& node : octree.nodes) {
    const auto children = std::uint32_t(std::popcount(node.mask));
    for (std::uint32_t i = node.first; i < node.first + children; ++i) {
      const Octree::Entry& e = octree.entries[i];
      if (e.log2 == 0) continue;  // descended into
      // A group of 2^3 children is in the tree as one entry for each that is not empty.
      double volume = std::ldexp(1.0, 3 * int(e.log2));
      if (e.grouped) volume /= 8;
      sum.hi += double(e.hi) * volume;
      sum.lo += double(e.lo) * volume;
    }
  }
  return sum;
}

TransmittanceChoice choose_transmittance(std::span<const Volume> volumes) {
  constexpr double kThick = 4, kMostlyControl = 0.5;
  TransmittanceChoice choice;
  BoundIntegrals all;
  for (const Volume& v : volumes) {
    if (v.octree.empty()) continue;
    const BoundIntegrals i = integrate_bounds(v.octree);
    const Vec3d size = v.octree.support().extent();
    const double surface = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
    const double cell = std::cbrt(1 / std::abs(determinant(v.world_to_cells)));
    // The mean chord of a convex body is 4 V / S (Cauchy).
    choice.thickness += 4 * 0.5 * (i.hi + i.lo) / surface * cell;
    all.hi += i.hi;
    all.lo += i.lo;
  }
  choice.control_share = all.hi > 0 ? all.lo / all.hi : 0;
  choice.estimator = choice.thickness > kThick               ? Transmittance::analog
                     : choice.control_share > kMostlyControl ? Transmittance::residual_ratio
                                                             : Transmittance::ratio;
  return choice;
}

}  // namespace pvol
