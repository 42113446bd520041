// Extinction fields for other renderers: a cloud from memory, then segments, free flights and
// transmittance along rays of the world, from any thread.
//
//   // Once: density on a lattice of 0.1 world units, mu_t = 4 x density.
//   const pvol::VoxelGrid grid =
//       pvol::make_grid({.values = data, .size = {nx, ny, nz}}, pvol::scaling(pvol::Vec3d(0.1)));
//   const pvol::Volume cloud = pvol::make_volume(grid, {.extinction = 4});
//
//   // For each ray, anywhere: where it collides, and how much of the light comes through.
//   pvol::Rng rng(seed, pixel, sample);
//   const pvol::Flight flight = pvol::sample_flight(cloud, {origin, direction}, t_max, rng);
//   const float shadow = pvol::sample_transmittance(cloud, {place, to_light}, distance, rng);
//
// Units. Lengths are in world units, mu_t is per world unit, optical depths have no unit. t is
// the distance from the ray's origin: directions are normalised on entry, whatever their length, so
// that the place at t is o + t d for a unit vector d.
//
// Threads and lifetime. A Volume has copies of all it needs: the grid may go. Nothing changes it,
// and any number of threads may use it at once, each with a RayWalk and an Rng of its own. A
// RayWalk and a field refer to their volume, which must stay where it is.
//
// Random numbers. An Rng is 24 bytes and made in no time: key one by (seed, pixel, sample) for each
// path and pass it on, or make one for each call by two 64-bit numbers from a generator of yours,
// Rng(yours(), yours(), 0). Equal keys give equal numbers on any thread and any machine.
//
// Errors. Making a grid or a volume throws Error (error.h) for input that is no density, no map or
// out of range. A ray that is not finite or has no direction throws Error too, since it would cast
// a shadow that nobody finds; a ray that misses is no error. Nothing else here throws.
//
// Several volumes may overlap: the shortest of their free flights is that of their sum, and their
// transmittances multiply.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "pvol/density/voxel_grid.h"
#include "pvol/error.h"
#include "pvol/track/transmittance.h"
#include "pvol/volume/volume.h"

namespace pvol {

// 1. Making a volume.

/// Bounds the grid's density and makes it ready for tracking: build_pyramid, then the make_volume
/// of volume.h, whose errors it throws. Of the medium, tracking needs `extinction` and
/// `object_to_world`, which is applied after the grid's map. volume.density.world_box bounds the
/// density.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Medium& medium,
                                 const VolumeOptions& options = {});

/// The same for a recipe (density/recipe.h), whose look-ups are procedural, whatever the options'
/// own interpolation: bounds in closed form, no samples.
[[nodiscard]] Volume make_volume(const Recipe& recipe, const Medium& medium,
                                 const VolumeOptions& options = {});

// 2. One call a ray.

/// The distance to the next collision, at most t_max, or none: `collided` is false. Analog, so that
/// its weight is 1; the density of t is mu_t(t) exp(-int_0^t mu_t).
[[nodiscard]] Flight sample_flight(const Volume& volume, const Ray& ray, double t_max, Rng& rng);

/// An unbiased estimate of the transmittance up to t_max, in [0, 1] give or take rounding. `ratio`
/// suits most rays. `analog`, which is 0 or 1, costs less in thick clouds; choose_transmittance
/// (volume/estimators.h) says once for a volume what suits it. Throws Error for `automatic`.
[[nodiscard]] float sample_transmittance(const Volume& volume, const Ray& ray, double t_max,
                                         Rng& rng, Transmittance estimator = Transmittance::ratio);

/// exp(-int mu_t) up to t_max in closed form, cell by cell, exact but for the rounding of positions
/// to 2^-24 cells a step (THEORY.md, T1.3). Throws Error for tricubic and procedural volumes, which
/// have no closed form.
[[nodiscard]] double exact_transmittance(const Volume& volume, const Ray& ray, double t_max);

/// rho and mu_t at a point of the world; 0 outside the cloud, and where the point is not finite.
/// The search starts at the octree's root: for points along a ray, a walk and a field know better.
[[nodiscard]] float density_at(const Volume& volume, Vec3d world);
[[nodiscard]] float extinction_at(const Volume& volume, Vec3d world);

// 3. Segments, for trackers of your own, and for paths that go on where they collided.
//
//   if (auto walk = pvol::enter(cloud, ray, t_max)) {
//     while (const auto s = walk->next()) { ... s->t0, s->t1, s->lo, s->hi ... }
//   }
//
// The trackers of flight.h, transmittance.h and regular.h take a RayWalk, a field and a Count,
// which is NoTally or a Tally of look-ups and the like:
//
//   pvol::visit_field(cloud, [&](const auto& field) {
//     pvol::NoTally none;
//     auto flight = pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none);
//     while (flight.collided) {                       // a path, without a search from the root
//       walk.emplace(pvol::resume(cloud, walk->cursor_at(flight.t), new_direction()));
//       flight = pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none);
//     }
//   });
//
// These are templates, compiled by you: give your compiler -ffp-contract=off for results that are
// equal to ours to the last bit, and never -ffast-math, which breaks them.

/// The segments of a ray of the world through a volume. Made by `enter` and `resume`.
class RayWalk {
 public:
  RayWalk(const Octree& tree, const Cursor& cursor, Vec3d cells_per_length, Span span)
      : walk_(tree, cursor, lanes(Vec3f(cells_per_length)), span.t1 - span.t0), span_(span) {}

  /// The next piece of the ray with lo <= mu_t <= hi and hi > 0, or nothing at the end: in order,
  /// apart, within [0, t_max], and with mu_t = 0 between them. Ends are rounded to a few ulps; so
  /// far from the origin that an ulp is as long as a segment, that segment may be empty.
  [[nodiscard]] std::optional<Segment> next() {
    auto s = walk_.next();
    if (s) {
      s->t0 = world(s->t0);
      s->t1 = world(s->t1);
    }
    return s;
  }

  /// The point at t of the current segment, for fields.
  [[nodiscard]] LatticePoint point(double t) const { return walk_.point(t - span_.t0); }

  /// The place at t of the current segment, for `resume`: after a flight that collided, that of its
  /// collision.
  [[nodiscard]] Cursor cursor_at(double t) const { return walk_.stop_at(point(t)); }

  /// The same segments with t counted from where the ray enters, and back. Trackers use these:
  /// their steps may be far shorter than an ulp of the way to the volume.
  [[nodiscard]] Walk& local() { return walk_; }
  [[nodiscard]] double world(double local_t) const {
    return std::min(span_.t0 + local_t, span_.t1);
  }

 private:
  Walk walk_;
  Span span_;
};

/// The walk of a ray from its origin, inside the volume or outside, up to t_max, which may be
/// infinite; nothing where it misses the box of the volume.
[[nodiscard]] std::optional<RayWalk> enter(const Volume& volume, const Ray& ray,
                                           double t_max = std::numeric_limits<double>::infinity());

/// The walk from a place where another ended, in a direction of the world; t counts from there.
[[nodiscard]] RayWalk resume(const Volume& volume, const Cursor& from, Vec3d direction,
                             double t_max = std::numeric_limits<double>::infinity());

/// f(field), and its result, with the field of the volume's interpolation and micro-bounds. That is
/// an ExtinctionField and, where the interpolation is nearest or trilinear, a CellField
/// (track/field.h): f needs `if constexpr (CellField<decltype(...)>)` around what regular.h has. f
/// is compiled for each kind of field; the choice costs a branch or two, so make it outside of
/// loops.
template <class F>
decltype(auto) visit_field(const Volume& volume, const F& f) {
  return visit_look_up(volume.density.look_up, [&](auto look_up) -> decltype(auto) {
    const auto source = extinction_source<look_up>(volume.density);
    using Source = std::remove_cvref_t<decltype(source)>;
    switch (volume.density.micro.edge) {
      case 1:
        return f(SqueezedField<1, Source>{source, volume.density.micro});
      case 2:
        return f(SqueezedField<2, Source>{source, volume.density.micro});
      default:
        return f(PlainField<Source>{source});
    }
  });
}

/// The trackers along a RayWalk: as along any other segments, with t from the ray's origin.
template <Tracker kTracker, class Field, class Count>
[[nodiscard]] Flight free_flight(RayWalk& walk, const Field& field, Rng& rng, Count& count) {
  Flight flight = free_flight<kTracker>(walk.local(), field, rng, count);
  flight.t = flight.collided ? walk.world(flight.t) : flight.t;
  return flight;
}

template <Transmittance kEstimator, Tracker kTracker, class Field, class Count,
          class Control = MinorantControl>
[[nodiscard]] float transmittance(RayWalk& walk, const Field& field, Rng& rng, Count& count,
                                  const Control& control = {}) {
  return transmittance<kEstimator, kTracker>(walk.local(), field, rng, count, control);
}

template <class Field, class Count>
[[nodiscard]] double optical_depth(RayWalk& walk, const Field& field, Count& count) {
  return optical_depth(walk.local(), field, count);
}

}  // namespace pvol
