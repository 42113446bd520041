// What rays of the world pass on their way through the volumes of a setup, without random numbers.
#pragma once

#include "render/engine/wavefront/world_rays.h"
#include "render/path/first_collision.h"

namespace pvol::test {

struct Passed {
  double first = detail::kEndless;  ///< where the first box that is not turned away begins
  double transmittance = 1;
};

/// Up to a distance, through what the wavefront visits at a time, by closed forms.
[[nodiscard]] inline Passed pass(const detail::PathSetup& s, const Ray& ray, float time, double end,
                                 detail::ShellCounts& shells) {
  Passed p;
  Rng none(1, 0, 0);
  detail::FlightMonitor monitor;
  const auto visit = [&](std::uint32_t i, double t0, double limit) {
    const detail::Instance at = s.instances->at_time(i, double(time));
    const detail::VolumeSetup& v = s.volumes[at.volume];
    Walk walk = detail::walk_through(v, at, ray, t0, limit - t0);
    p.first = std::min(p.first, t0);
    p.transmittance *= double(v.flights.transmittance(
        Transmittance::regular, Tracker::decomposition, v.volume.density, walk, none, monitor));
    return limit;
  };
  detail::visit_instances(s, ray, time, end, detail::WorldRay::kNowhere, shells, visit);
  return p;
}

}  // namespace pvol::test
