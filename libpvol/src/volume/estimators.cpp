#include "pvol/volume/estimators.h"

#include <algorithm>
#include <cmath>

#include "bounds/octree_children.h"
#include "pvol/bounds/integrals.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/field/micro_range.h"
#include "pvol/volume/extinction_source.h"
#include "pvol/volume/facts.h"

namespace pvol {
namespace {

/// Integrals over what segments with bounds of `terminal` look up below a link.
class OpenIntegral {
 public:
  explicit OpenIntegral(const Volume& volume) : v_(volume) {}

  double sum = 0;

  /// Below a node, under the terminal that holds it or, where there is none, from the top down.
  void add(const Octree::Node& node, Vec3i low, const Octree::Entry* terminal) {
    detail::for_children(
        v_.density.octree, node, low, [&](const Octree::Entry& e, Vec3i at, int edge) {
          const Octree::Entry* bounds = terminal != nullptr ? terminal : e.log2 != 0 ? &e : nullptr;
          if (e.link & Octree::kNodeBit) {
            add(v_.density.octree.nodes[e.link & ~Octree::kNodeBit], at, bounds);
          } else if (edge <= kLeafEdge) {  // larger cubes have one density, which micro-bounds know
            add_cube(e.link, at, edge, *bounds);
          }
        });
  }

 private:
  const Volume& v_;

  /// Of a cube: what codes say in its middle, or micro-bounds anywhere.
  [[nodiscard]] DensityRange range_in(std::uint32_t brick, Vec3i at) const {
    if (v_.density.codes == nullptr) return micro_range(v_.density.micro, brick, widen(at));
    return visit_closed_look_up(v_.density.look_up, [&](auto look_up) {
      return code_range<look_up>(*v_.density.codes, brick, {widen(at), splat(0.5f)});
    });
  }

  /// A leaf, or a part of one.
  void add_cube(std::uint32_t brick, Vec3i low, int length, const Octree::Entry& bounds) {
    const int edge = v_.density.codes ? 1 : v_.density.micro.edge, n = length / edge;
    const Vec3i first = vec3(v_.density.octree.support_lo),
                last = vec3(v_.density.octree.support_hi);
    for (Vec3i c; c.x < n; ++c.x) {
      for (c.y = 0; c.y < n; ++c.y) {
        for (c.z = 0; c.z < n; ++c.z) {
          const Vec3i at = low + c * edge;
          const Vec3d extent(max(min(at + Vec3i(edge), last) - max(at, first), Vec3i(0)));
          const DensityRange r = range_in(brick, at);
          const double open = double(std::min(v_.density.scale * r.hi, bounds.hi)) -
                              double(std::max(v_.density.scale * r.lo, bounds.lo));
          sum += std::max(0.0, open) * extent.x * extent.y * extent.z;
        }
      }
    }
  }
};

}  // namespace

double integrate_open(const Volume& volume) {
  if (squeeze_of(volume.density) == Squeeze::none) {
    const BoundIntegrals b = integrate_bounds(volume.density.octree);
    return b.hi - b.lo;
  }
  OpenIntegral open(volume);
  if (!volume.density.octree.empty()) open.add(volume.density.octree.nodes[0], {0, 0, 0}, nullptr);
  return open.sum;
}

TransmittanceChoice choose_transmittance(std::span<const Volume> volumes) {
  constexpr double kThick = 4, kMostlyControl = 0.5;
  TransmittanceChoice choice;
  BoundIntegrals all;
  for (const Volume& v : volumes) {
    if (v.density.octree.empty()) continue;
    const BoundIntegrals i = integrate_bounds(v.density.octree);
    const Vec3d size = v.density.octree.support().extent();
    const double surface = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
    double cell = 0;  // edge, on average over the places
    for (std::size_t place = 0; place < count_places(v); ++place) {
      const Affine to_cells = v.density.world_to_cells * to_first_place(v, place);
      cell += std::cbrt(1 / std::abs(determinant(to_cells))) / double(count_places(v));
    }
    const double hi = i.hi / v.density.majorant_scale;
    // The mean chord of a convex body is 4 V / S (Cauchy).
    choice.thickness += 4 * 0.5 * (hi + i.lo) / surface * cell;
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
