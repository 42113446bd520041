// Many rays at once, on all threads: the loops behind flights, transmittance and optical_depth.
#pragma once

#include <cstdint>
#include <functional>

#include "pvol/track/tracker.h"
#include "pvol/volume/batch.h"
#include "pvol/volume/volume.h"
#include "python/cancellable.h"
#include "python/views.h"

namespace pvol::python {

/// Where what each ray took is counted (track/tally.h); null where nobody asks.
struct CountColumns {
  std::uint64_t* lookups = nullptr;
  std::uint64_t* bounds_tests = nullptr;
  std::uint64_t* segments = nullptr;
  std::uint64_t* null_collisions = nullptr;
};

/// A number for each ray, and counts.
struct RayNumbers {
  double* value = nullptr;
  CountColumns counts{};
};

// Ray i takes the random numbers of Rng(seed, i, 0), whatever the threads. All throw Error, naming
// the ray, for one that is not finite or has no direction, and for closed forms of fields that have
// none. Where `stop` becomes true they end early, and the numbers mean nothing.

/// Distances to the next collision, infinite where there is none up to t_max. Their weights are 1,
/// since a volume's bounds hold. Throws Error for delta_global, which is a matter of the volume's
/// octree.
void sample_flights(const Volume& volume, const RayViews& rays, Tracker tracker, std::uint64_t seed,
                    const RayNumbers& to, const Stop& stop);

/// The same by decomposition with many rays in flight at once, without counts: the same law by
/// other random numbers than one ray at a time. `field` is of the volume.
void sample_flights_at_once(const Volume& volume, const BatchField& field, const RayViews& rays,
                            std::uint64_t seed, double* t, const Stop& stop);
void sample_transmittances_at_once(const Volume& volume, const BatchField& field,
                                   const RayViews& rays, Transmittance estimator,
                                   std::uint64_t seed, double* passed, const Stop& stop);

/// Unbiased estimates of transmittances; `automatic` is what choose_transmittance says.
void sample_transmittances(const Volume& volume, const RayViews& rays, Transmittance estimator,
                           std::uint64_t seed, const RayNumbers& to, const Stop& stop);

/// int mu_t dt, exact (THEORY.md, T1.3); look-ups are cells crossed.
void find_optical_depths(const Volume& volume, const RayViews& rays, const RayNumbers& to,
                         const Stop& stop);

/// Rays that a thread takes at a time: a millisecond or so, then it asks whether to stop.
inline constexpr std::size_t kPart = 512;

/// Calls part(begin, end) for parts of [0, count) of at most `most`, in any order and from several
/// threads, until `stop` is true.
void for_each_part(std::size_t count, std::size_t most, const Stop& stop,
                   const std::function<void(std::size_t begin, std::size_t end)>& part);

}  // namespace pvol::python
