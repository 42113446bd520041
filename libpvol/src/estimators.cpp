#include "pvol/render/estimators.h"

#include <algorithm>
#include <cmath>

#include "octree_children.h"
#include "pvol/error.h"
#include "pvol/render/render.h"

namespace pvol {

namespace {

void add_node(const Octree& tree, const Octree::Node& node, Vec3i low, BoundIntegrals& sum) {
  detail::for_children(tree, node, low, [&](const Octree::Entry& e, Vec3i at, int edge) {
    if (e.log2 == 0) return add_node(tree, tree.nodes[e.link & ~Octree::kNodeBit], at, sum);
    // Of a group of eight children, each adds its own cube. Walks end at the support's box.
    const Vec3i end = min(at + Vec3i(edge), vec3(tree.support_hi));
    const Vec3d extent(max(end - max(at, vec3(tree.support_lo)), Vec3i(0)));
    const double cells = extent.x * extent.y * extent.z;
    sum.lo += double(e.lo) * cells;
    sum.hi += double(e.hi) * cells;
  });
}

/// Integrals over what segments with bounds of `terminal` look up below a link.
class OpenIntegral {
 public:
  explicit OpenIntegral(const Volume& volume) : v_(volume) {}

  double sum = 0;

  /// Below a node, under the terminal that holds it or, where there is none, from the top down.
  void add(const Octree::Node& node, Vec3i low, const Octree::Entry* terminal) {
    detail::for_children(v_.octree, node, low, [&](const Octree::Entry& e, Vec3i at, int edge) {
      const Octree::Entry* bounds = terminal != nullptr ? terminal : e.log2 != 0 ? &e : nullptr;
      if (e.link & Octree::kNodeBit) {
        add(v_.octree.nodes[e.link & ~Octree::kNodeBit], at, bounds);
      } else if (edge == kLeafEdge) {  // larger cubes have one density, which micro-bounds know
        add_leaf(e.link, at, *bounds);
      }
    });
  }

 private:
  const Volume& v_;

  void add_leaf(std::uint32_t brick, Vec3i low, const Octree::Entry& bounds) {
    const int edge = v_.micro.edge, n = kLeafEdge / edge;
    const Vec3i first = vec3(v_.octree.support_lo), last = vec3(v_.octree.support_hi);
    for (Vec3i c; c.x < n; ++c.x) {
      for (c.y = 0; c.y < n; ++c.y) {
        for (c.z = 0; c.z < n; ++c.z) {
          const Vec3i at = low + c * edge;
          const Vec3d extent(max(min(at + Vec3i(edge), last) - max(at, first), Vec3i(0)));
          const DensityRange r = edge == 1 ? micro_range<1>(v_.micro, brick, lanes(at))
                                           : micro_range<2>(v_.micro, brick, lanes(at));
          const double open = double(std::min(v_.extinction * r.hi, bounds.hi)) -
                              double(std::max(v_.extinction * r.lo, bounds.lo));
          sum += std::max(0.0, open) * extent.x * extent.y * extent.z;
        }
      }
    }
  }
};

}  // namespace

double integrate_open(const Volume& volume) {
  if (volume.micro.edge == 0) {
    const BoundIntegrals b = integrate_bounds(volume.octree);
    return b.hi - b.lo;
  }
  OpenIntegral open(volume);
  if (!volume.octree.empty()) open.add(volume.octree.nodes[0], {0, 0, 0}, nullptr);
  return open.sum;
}

BoundIntegrals integrate_bounds(const Octree& octree) {
  BoundIntegrals sum;
  if (!octree.empty()) add_node(octree, octree.nodes[0], {0, 0, 0}, sum);
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

namespace {

/// Why paths cannot be guided, or null.
const char* obstacle(std::span<const Volume> volumes, const RenderOptions& o) {
  if (volumes.size() != 1) return "there are several volumes";
  if (is_weighted(o.tracker)) return "the tracker has weights";
  if (o.max_bounces) return "bounces are limited";
  if (o.interpolation != Interpolation::nearest && o.interpolation != Interpolation::trilinear) {
    return "the interpolation is neither nearest nor trilinear";
  }
  return nullptr;
}

double largest_albedo(const Medium& medium) {
  double albedo = double(max_component(medium.albedo));
  for (const Component& c : medium.others) {
    if (c.share > 0) albedo = std::max(albedo, double(max_component(c.albedo)));
  }
  return albedo;
}

}  // namespace

GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene) {
  constexpr double kScatterings = 5;  // of a path, from which on guiding has something to choose
  constexpr double kPaths = 1 << 17;  // that take longer than the photons
  const RenderOptions& o = scene.options;
  if (o.guide == GuideUse::off) return {false, "as told"};
  if (const char* reason = obstacle(volumes, o)) {
    if (o.guide == GuideUse::automatic) return {false, reason};
    throw Error(std::string("paths cannot be guided: ") + reason +
                "; leave guide at auto, or change that");
  }
  if (o.guide == GuideUse::on) return {true, "as told"};
  const double thickness = choose_transmittance(volumes).thickness;
  const double scatterings = estimate_scatterings(thickness, largest_albedo(scene.medium));
  if (scatterings < kScatterings) return {false, "paths are short", scatterings};
  if (double(o.width) * o.height * o.samples < kPaths) {
    return {false, "the picture takes less time than a guide", scatterings};
  }
  return {true, "paths are long", scatterings};
}

}  // namespace pvol
