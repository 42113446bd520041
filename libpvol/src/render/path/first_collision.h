// Where a ray of the world collides first, for those who follow few.
#pragma once

#include <algorithm>
#include <optional>

#include "pvol/bounds/walk.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// A walk along a ray of the world through an instance from t0 on, over a length.
[[nodiscard]] inline Walk walk_through(const VolumeSetup& v, const Instance& at, const Ray& ray,
                                       double t0, double length) {
  const Octree& tree = v.volume.density.octree;
  return {tree, make_cursor(tree, at.in_cells(ray).at(t0)), at.in_cells(Vec3f(ray.d)), length};
}

/// The nearest of the collisions in all instances, as they are at a time (THEORY.md, T3.8), for a
/// tracker without weights. Surfaces are not asked.
[[nodiscard]] inline std::optional<Vec3d> first_collision(const PathSetup& s, const Ray& ray,
                                                          float time, Rng& rng) {
  double nearest = kEndless;
  FlightMonitor monitor{{}, s.stop, time};
  s.instances->tree.visit(ray, kEndless, [&](std::uint32_t i, double limit) {
    const Instance at = s.instances->at_time(i, double(time));
    const VolumeSetup& v = s.volumes[at.volume];
    const auto span = v.in_box(at.in_cells(ray));
    if (!span || !(span->t0 < limit)) return limit;
    Walk walk = walk_through(v, at, ray, span->t0, limit - span->t0);
    const Flight f = v.flights.fly(s.options.tracker, v.volume.density, walk, rng, monitor);
    if (f.collided) nearest = std::min(limit, span->t0 + f.t);
    return std::min(limit, nearest);
  });
  if (nearest == kEndless) return std::nullopt;
  return ray.at(nearest);
}

}  // namespace pvol::detail
