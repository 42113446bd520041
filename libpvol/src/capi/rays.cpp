// Calls of the C API that are complete in themselves: random numbers, and one call a ray.
#include "capi/rays.h"

#include <cmath>
#include <limits>

namespace pvol::detail {
namespace {

/// f(rng) with pvol's own stream, which is used on.
template <class F>
[[nodiscard]] auto with_own(pvol_random& random, const F& f) {
  Rng rng = own_stream(random);
  const auto result = f(rng);
  random.used = rng.state().counter;
  return result;
}

}  // namespace

Flight fly(const Committed& c, RayWalk& walk, pvol_random& random) {
  const VolumeField& field = c.volume->density;
  if (!is_own(random)) {
    CallerNumbers numbers(random);
    return c.kernels.fly(field, walk, numbers);
  }
  Flight flight = with_own(random, [&](Rng& rng) {
    FlightMonitor unused;
    return c.flights.fly(Tracker::decomposition, field, walk.local(), rng, unused);
  });
  if (flight.collided) flight.t = walk.world(flight.t);
  return flight;
}

float estimate_transmittance(const Committed& c, pvol_estimator estimator, RayWalk& walk,
                             pvol_random& random) {
  const VolumeField& field = c.volume->density;
  if (!is_estimator(estimator)) return std::numeric_limits<float>::quiet_NaN();
  if (estimator == PVOL_EXACT) {
    if (c.kernels.depth == nullptr) return std::numeric_limits<float>::quiet_NaN();
    return float(std::exp(-c.kernels.depth(field, walk)));
  }
  if (!is_own(random)) {
    CallerNumbers numbers(random);
    return c.kernels.transmittance(field, estimator_of(estimator), walk, numbers);
  }
  const Tracker tracker = estimator == PVOL_ANALOG ? Tracker::decomposition : Tracker::delta;
  return with_own(random, [&](Rng& rng) {
    FlightMonitor unused;
    return c.flights.transmittance(estimator_of(estimator), tracker, field, walk.local(), rng,
                                   unused);
  });
}

}  // namespace pvol::detail

using namespace pvol;
using namespace pvol::detail;

extern "C" {

void pvol_seed(pvol_random* random, uint64_t seed, uint64_t stream, uint64_t sample) {
  const Rng::State state = Rng(seed, stream, sample).state();
  *random = {};
  random->key[0] = state.key, random->key[1] = state.sample;
}

double pvol_uniform(pvol_random* random) { return CallerNumbers(*random).one(); }

int pvol_sample_flight(const pvol_volume* volume, const pvol_ray* ray, pvol_random* random,
                       double* t) {
  if (ray == nullptr || random == nullptr || t == nullptr) return PVOL_BAD_RAY;
  const Committed* const c = committed(volume);
  RayWalk walk;
  const Entry entry = enter(c, *ray, walk);
  if (entry == Entry::bad) return PVOL_BAD_RAY;
  if (entry == Entry::misses) return 0;
  const Flight flight = fly(*c, walk, *random);
  if (flight.collided) *t = flight.t;
  return flight.collided ? 1 : 0;
}

int pvol_sample_transmittance(const pvol_volume* volume, const pvol_ray* ray,
                              pvol_estimator estimator, pvol_random* random, float* transmittance) {
  if (ray == nullptr || random == nullptr || transmittance == nullptr) return PVOL_BAD_RAY;
  const Committed* const c = committed(volume);
  RayWalk walk;
  const Entry entry = enter(c, *ray, walk);
  if (entry == Entry::bad || !is_estimator(estimator)) return PVOL_BAD_RAY;
  if (estimator == PVOL_EXACT && c->kernels.depth == nullptr) return PVOL_BAD_RAY;
  *transmittance =
      entry == Entry::misses ? 1 : estimate_transmittance(*c, estimator, walk, *random);
  return 1;
}

int pvol_optical_depth(const pvol_volume* volume, const pvol_ray* ray, double* depth) {
  if (ray == nullptr || depth == nullptr) return PVOL_BAD_RAY;
  const Committed* const c = committed(volume);
  RayWalk walk;
  const Entry entry = enter(c, *ray, walk);
  if (entry == Entry::bad || c->kernels.depth == nullptr) return PVOL_BAD_RAY;
  *depth = entry == Entry::misses ? 0 : c->kernels.depth(c->volume->density, walk);
  return 1;
}

}  // extern "C"
