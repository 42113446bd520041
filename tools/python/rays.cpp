#include "python/rays.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "pvol/trackers.h"
#include "pvol/volume/estimators.h"

namespace pvol::python {
namespace {

/// The same of many at once, whose call has a price of its own.
constexpr std::size_t kPartAtOnce = 8192;

[[noreturn]] void refuse_closed_form() {
  throw Error(
      "the optical depth has a closed form for nearest and trilinear interpolation only; choose "
      "another estimator or tracker for this volume");
}

void put(const CountColumns& to, std::size_t i, const Tally& tally) {
  if (to.lookups == nullptr) return;
  to.lookups[i] = tally.lookups;
  to.bounds_tests[i] = tally.bounds_tests;
  to.segments[i] = tally.segments;
  to.null_collisions[i] = tally.null_collisions;
}

/// number = one(walk, field, rng, tally) for each ray that meets the volume's box, `missed` for the
/// others. Counting costs a few increments of registers, so that it is always done.
template <class One>
void for_each_ray(const Volume& volume, const RayViews& rays, std::uint64_t seed, double missed,
                  const RayNumbers& to, const Stop& stop, const One& one) {
  const auto do_ray = [&](std::size_t i, const auto& field) {
    Tally tally;
    Rng rng(seed, i, 0);
    auto walk = enter(volume, rays[i], rays.t_max[i]);
    to.value[i] = walk ? one(*walk, field, rng, tally) : missed;
    put(to.counts, i, tally);
  };
  for_each_part(rays.count(), kPart, stop, [&](std::size_t begin, std::size_t end) {
    visit_field(volume, [&](const auto& field) {
      for (std::size_t i = begin; i != end; ++i) {
        try {
          do_ray(i, field);
        } catch (const Error& e) {
          throw Error("ray " + std::to_string(i) + ": " + e.what());
        }
      }
    });
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
  if (!has_closed_form(volume.density.look_up)) refuse_closed_form();
}

/// The same for a tracker or an estimator that needs cells or not.
template <bool kCells, class One>
void for_each_field(const Volume& volume, const RayViews& rays, std::uint64_t seed, double missed,
                    const RayNumbers& to, const Stop& stop, const One& one) {
  for_each_ray(volume, rays, seed, missed, to, stop,
               [&](RayWalk& walk, const auto& field, Rng& rng, Tally& tally) -> double {
                 if constexpr (kCells && !CellField<std::remove_cvref_t<decltype(field)>>) {
                   refuse_closed_form();
                 } else {
                   return one(walk, field, rng, tally);
                 }
               });
}

template <Tracker kTracker>
void fly(const Volume& volume, const RayViews& rays, std::uint64_t seed, const RayNumbers& to,
         const Stop& stop) {
  for_each_field<kTracker == Tracker::regular>(
      volume, rays, seed, std::numeric_limits<double>::infinity(), to, stop,
      [](RayWalk& walk, const auto& field, Rng& rng, Tally& tally) {
        return free_flight<kTracker>(walk, field, rng, tally).t;
      });
}

/// By which `analog` flies; ratios pass tentative collisions against majorants alone.
template <Transmittance kEstimator>
constexpr Tracker kTrackerOf =
    kEstimator == Transmittance::analog ? Tracker::decomposition : Tracker::delta;

template <Transmittance kEstimator>
void pass(const Volume& volume, const RayViews& rays, std::uint64_t seed, const RayNumbers& to,
          const Stop& stop) {
  for_each_field<false>(
      volume, rays, seed, 1, to, stop,
      [](RayWalk& walk, const auto& field, Rng& rng, Tally& tally) {
        return double(transmittance<kEstimator, kTrackerOf<kEstimator>>(walk, field, rng, tally));
      });
}

template <class Number>
void depths(const Volume& volume, const RayViews& rays, double missed, const RayNumbers& to,
            const Stop& stop, const Number& number) {
  require_closed_form(volume);
  for_each_field<true>(volume, rays, 0, missed, to, stop,
                       [&](RayWalk& walk, const auto& field, Rng&, Tally& tally) {
                         return number(optical_depth(walk, field, tally));
                       });
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
  switch (tracker) {
    case Tracker::delta:
      return fly<Tracker::delta>(volume, rays, seed, to, stop);
    case Tracker::decomposition:
      return fly<Tracker::decomposition>(volume, rays, seed, to, stop);
    case Tracker::weighted_delta:
      return fly<Tracker::weighted_delta>(volume, rays, seed, to, stop);
    case Tracker::weighted_decomposition:
      return fly<Tracker::weighted_decomposition>(volume, rays, seed, to, stop);
    case Tracker::regular:
      require_closed_form(volume);
      return fly<Tracker::regular>(volume, rays, seed, to, stop);
    case Tracker::delta_global:
      break;
  }
  throw Error(
      "delta-global is delta with one majorant for the whole volume: make the volume with depth=0 "
      "and use the tracker delta");
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
  switch (estimator) {
    case Transmittance::ratio:
      return pass<Transmittance::ratio>(volume, rays, seed, to, stop);
    case Transmittance::residual_ratio:
      return pass<Transmittance::residual_ratio>(volume, rays, seed, to, stop);
    case Transmittance::regular:
      return depths(volume, rays, 1, to, stop, [](double depth) { return std::exp(-depth); });
    default:
      return pass<Transmittance::analog>(volume, rays, seed, to, stop);
  }
}

void find_optical_depths(const Volume& volume, const RayViews& rays, const RayNumbers& to,
                         const Stop& stop) {
  depths(volume, rays, 0, to, stop, [](double depth) { return depth; });
}

}  // namespace pvol::python
