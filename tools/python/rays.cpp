#include "python/rays.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "pvol/trackers.h"
#include "pvol/volume/counted_rays.h"
#include "pvol/volume/estimators.h"

namespace pvol::python {
namespace {

/// The same of many at once, whose call has a price of its own.
constexpr std::size_t kPartAtOnce = 8192;

void put(const CountColumns& to, std::size_t i, const Tally& tally) {
  if (to.lookups == nullptr) return;
  to.lookups[i] = tally.lookups;
  to.bounds_tests[i] = tally.bounds_tests;
  to.segments[i] = tally.segments;
  to.null_collisions[i] = tally.null_collisions;
}

/// number = one(ray, t_max, rng, tally) for each ray. Counting costs a few increments of registers,
/// so that it is always done.
template <class One>
void for_each_ray(const RayViews& rays, std::uint64_t seed, const RayNumbers& to, const Stop& stop,
                  const One& one) {
  for_each_part(rays.count(), kPart, stop, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      try {
        Tally tally;
        Rng rng(seed, i, 0);
        to.value[i] = one(rays[i], rays.t_max[i], rng, tally);
        put(to.counts, i, tally);
      } catch (const Error& e) {
        throw Error("ray " + std::to_string(i) + ": " + e.what());
      }
    }
  });
}

[[nodiscard]] VectorArray part_of(const Vectors& v, std::size_t begin) {
  return {v.data + v.step * long(begin), true, v.step, v.axis};
}

/// Calls run(batch, numbers, begin), which returns how many rays were bad, for parts of the rays.
template <class Run>
void for_each_batch(const Volume& volume, const RayViews& rays, std::uint64_t seed,
                    const Stop& stop, const Run& run) {
  const auto refuse = [&](std::size_t i) {
    try {
      (void)enter(volume, rays[i], rays.t_max[i]);
    } catch (const Error& e) {
      throw Error("ray " + std::to_string(i) + ": " + e.what());
    }
  };
  for_each_part(rays.count(), kPartAtOnce, stop, [&](std::size_t begin, std::size_t end) {
    const RayBatch batch{end - begin,
                         part_of(rays.origins, begin),
                         part_of(rays.directions, begin),
                         {rays.t_max.data + rays.t_max.step * long(begin), true, rays.t_max.step}};
    if (run(batch, BatchNumbers{.seed = seed, .first = begin}, begin) == 0) return;
    for (std::size_t i = begin; i != end; ++i) refuse(i);
  });
}

void require_closed_form(const Volume& volume) {
  if (has_closed_form(volume.density.look_up)) return;
  throw Error(
      "the optical depth has a closed form for nearest and trilinear interpolation only; choose "
      "another estimator or tracker for this volume");
}

}  // namespace

void for_each_part(std::size_t count, std::size_t most, const Stop& stop,
                   const std::function<void(std::size_t begin, std::size_t end)>& part) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto one = [&](const Range& r) {
    if (!stop.load(std::memory_order_relaxed)) part(r.begin(), r.end());
  };
  tbb::parallel_for(Range(0, count, most), one, tbb::simple_partitioner{});
}

void sample_flights(const Volume& volume, const RayViews& rays, Tracker tracker, std::uint64_t seed,
                    const RayNumbers& to, const Stop& stop) {
  if (tracker == Tracker::delta_global) {
    throw Error(
        "delta-global is delta with one majorant for the whole volume: make the volume with "
        "depth=0 and use the tracker delta");
  }
  if (tracker == Tracker::regular) require_closed_form(volume);
  for_each_ray(rays, seed, to, stop, [&](const Ray& ray, double t_max, Rng& rng, Tally& tally) {
    const Flight flight = sample_flight(volume, ray, t_max, rng, tracker, tally);
    return flight.collided ? flight.t : std::numeric_limits<double>::infinity();
  });
}

void sample_flights_at_once(const Volume& volume, const BatchField& field, const RayViews& rays,
                            std::uint64_t seed, double* t, const Stop& stop) {
  for_each_batch(volume, rays, seed, stop,
                 [&](const RayBatch& batch, const BatchNumbers& numbers, std::size_t begin) {
                   return pvol::sample_flights(field, batch, numbers, t + begin);
                 });
}

void sample_transmittances_at_once(const Volume& volume, const BatchField& field,
                                   const RayViews& rays, Transmittance estimator,
                                   std::uint64_t seed, double* passed, const Stop& stop) {
  for_each_batch(volume, rays, seed, stop,
                 [&](const RayBatch& batch, const BatchNumbers& numbers, std::size_t begin) {
                   std::vector<float> part(batch.size);
                   const std::size_t bad =
                       pvol::sample_transmittances(field, batch, numbers, estimator, part.data());
                   std::copy(part.begin(), part.end(), passed + begin);
                   return bad;
                 });
}

void sample_transmittances(const Volume& volume, const RayViews& rays, Transmittance estimator,
                           std::uint64_t seed, const RayNumbers& to, const Stop& stop) {
  if (estimator == Transmittance::automatic) {
    estimator = choose_transmittance({&volume, 1}).estimator;
  }
  if (estimator == Transmittance::regular) require_closed_form(volume);
  for_each_ray(rays, seed, to, stop,
               [&](const Ray& ray, double t_max, Rng& rng, Tally& tally) -> double {
                 if (estimator == Transmittance::regular) {
                   return std::exp(-exact_optical_depth(volume, ray, t_max, tally));
                 }
                 return double(sample_transmittance(volume, ray, t_max, rng, estimator, tally));
               });
}

void find_optical_depths(const Volume& volume, const RayViews& rays, const RayNumbers& to,
                         const Stop& stop) {
  require_closed_form(volume);
  for_each_ray(rays, 0, to, stop, [&](const Ray& ray, double t_max, Rng&, Tally& tally) {
    return exact_optical_depth(volume, ray, t_max, tally);
  });
}

}  // namespace pvol::python
