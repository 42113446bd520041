// Trackers and paths from segments and fields: the manual is pvol/trackers.h.
#include "pvol/trackers.h"

#include <cmath>
#include <numbers>

#include "consumer.h"

bool passes(const pvol::Volume& cloud, const pvol::Ray& ray, pvol::Rng& rng) {
  auto walk = pvol::enter(cloud, ray);
  if (!walk) return true;
  return pvol::visit_field(cloud, [&](const auto& field) {
    pvol::NoTally none;
    while (const auto s = walk->next()) {
      double t = s->t0;
      for (;;) {
        const auto [depth, u] = rng.tentative();
        t += double(depth) / double(s->hi);
        if (t >= s->t1) break;
        if (field.exceeds(*s, walk->point(t), u * s->hi, none)) return false;
      }
    }
    return true;
  });
}

int count_turns(const pvol::Volume& cloud, const pvol::Ray& ray, pvol::Rng& rng) {
  const auto new_direction = [&rng] {
    const auto [a, b] = rng.uniform2();
    const double z = 2 * double(a) - 1, r = std::sqrt(1 - z * z),
                 phi = 2 * std::numbers::pi * double(b);
    return pvol::Vec3d(r * std::cos(phi), r * std::sin(phi), z);
  };
  int turns = 0;
  if (auto walk = pvol::enter(cloud, ray)) {
    pvol::visit_field(cloud, [&](const auto& field) {
      pvol::NoTally none;
      auto flight = pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none);
      while (flight.collided) {
        ++turns;
        walk.emplace(pvol::resume(cloud, walk->cursor_at(flight.t), new_direction()));
        flight = pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none);
      }
    });
  }
  return turns;
}
