// Flights that are told to stop.
#include "volume/flights.h"

#include <gtest/gtest.h>

#include "pvol/bounds/pyramid.h"
#include "pvol/trackers.h"
#include "pvol/volume/make_volume.h"
#include "support/fields.h"

namespace pvol::test {
namespace flights_test {

using detail::find_flights;
using detail::FlightMonitor;
using detail::Flights;

/// Empty but for two voxels far from each other, under one majorant: 10^14 null collisions lie on a
/// ray between them.
Volume make_stray_volume(LookUp look_up, MicroBoundsUse micro_bounds) {
  static const Field f = make_field("stray", {0, 0, 0}, {64, 64, 64}, [](Vec3i p) {
    return p == Vec3i(0) || p == Vec3i(63) ? 1.0 : 0.0;
  });
  VolumeOptions o{.look_up = look_up, .micro_bounds = micro_bounds, .depth = 0};
  return make_volume(f.grid, build_pyramid(f.grid, look_up), Medium{.extinction = 1e12}, o);
}

TEST(Flights, StopHoweverManyNullCollisionsLieAhead) {
  const std::atomic<bool> stop = true;
  for (const LookUp look_up : {LookUp::nearest, LookUp::trilinear, LookUp::tricubic}) {
    for (const auto micro : {MicroBoundsUse::none, MicroBoundsUse::edge_2, MicroBoundsUse::edge_1,
                             MicroBoundsUse::codes}) {
      const Volume v = make_stray_volume(look_up, micro);
      const Flights flights = find_flights(detail::kind_of(v.density));
      Rng rng(1, 2, 3);
      FlightMonitor monitor{{}, &stop};
      const auto walk = [&] { return *enter(v, {{-9, 30, 33}, {1, 0, 0}}, 1e3); };
      for (const Tracker tracker : {Tracker::delta, Tracker::delta_global, Tracker::decomposition,
                                    Tracker::weighted_delta, Tracker::weighted_decomposition}) {
        EXPECT_TRUE(flights.fly(tracker, v.density, walk().local(), rng, monitor).collided);
        for (const auto estimator :
             {Transmittance::analog, Transmittance::ratio, Transmittance::residual_ratio}) {
          EXPECT_EQ(
              flights.transmittance(estimator, tracker, v.density, walk().local(), rng, monitor),
              0);
        }
      }
    }
  }
}

}  // namespace flights_test
}  // namespace pvol::test
