// Trackers of your own along rays of the world, where the calls of pvol/embed.h are not enough:
// segments of constant bounds, fields that answer for the density, and the trackers that pvol
// itself is made of.
//
//   // The segments of a ray: where it may collide, and at which rates.
//   if (auto walk = pvol::enter(cloud, ray, t_max)) {
//     while (const auto s = walk->next()) { ... s->t0, s->t1, s->lo, s->hi ... }
//   }
//
// The trackers of flight.h, transmittance.h and regular.h take a RayWalk, a field and a Count,
// which is NoTally or a Tally of look-ups and the like:
//
//   // A path through the cloud, without a search from the octree's root at each collision.
//   if (auto walk = pvol::enter(cloud, ray)) {
//     pvol::visit_field(cloud, [&](const auto& field) {
//       pvol::NoTally none;
//       auto flight = pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none);
//       while (flight.collided) {
//         walk.emplace(pvol::resume(cloud, walk->cursor_at(flight.t), new_direction()));
//         flight = pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none);
//       }
//     });
//   }
//
// A tracker of yours asks the same questions: field.extinction(s, walk->point(t), none) for mu_t at
// t of the segment s, or field.exceeds(s, walk->point(t), u * s.hi, none), which may know the
// answer without a look-up (track/field.h).
//
// Lifetime. A RayWalk and a field refer to their volume, which must stay where it is, and belong to
// one thread. Units, random numbers and errors are those of embed.h.
//
// Rounding. These are templates, compiled by you: give your compiler -ffp-contract=off for results
// that are equal to ours to the last bit, and never -ffast-math, which breaks them.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <type_traits>

#include "pvol/bounds/walk.h"
#include "pvol/embed.h"
#include "pvol/track/field.h"
#include "pvol/track/flight.h"
#include "pvol/track/regular.h"
#include "pvol/track/tally.h"
#include "pvol/track/transmittance.h"
#include "pvol/volume/extinction_source.h"

namespace pvol {

/// The segments of a ray of the world through a volume. Made by `enter` and `resume`.
class RayWalk {
 public:
  RayWalk() = default;  ///< without segments
  RayWalk(const Octree& tree, const Cursor& cursor, Vec3d cells_per_length, Span span)
      : walk_(tree, cursor, widen(Vec3f(cells_per_length)), span.t1 - span.t0), span_(span) {}
  RayWalk(const Octree& tree, const LatticePoint& from, Vec3d cells_per_length, Span span)
      : walk_(tree, from, widen(Vec3f(cells_per_length)), span.t1 - span.t0), span_(span) {}

  /// The next piece of the ray with lo <= mu_t <= hi and hi > 0, or nothing at the end: in order,
  /// apart, within [0, t_max], and with mu_t = 0 between them. Ends are rounded to a few ulps; so
  /// far from the origin that an ulp is as long as a segment, that segment may be empty.
  [[nodiscard, gnu::always_inline]] std::optional<Segment> next() {
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

  /// A handle of the current segment, also after a flight, for look-ups by a field's source.
  [[nodiscard]] LeafHandle handle() const { return walk_.handle(); }

  /// Where the ray is in the box of the volume.
  [[nodiscard]] Span span() const { return span_; }

  /// The same segments with t counted from where the ray enters, and back. Trackers use these:
  /// their steps may be far shorter than an ulp of the way to the volume.
  [[nodiscard]] Walk& local() { return walk_; }
  [[nodiscard]] double world(double local_t) const {
    return std::min(span_.t0 + local_t, span_.t1);
  }

 private:
  Walk walk_;
  Span span_{};
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
  if (volume.density.map != nullptr) {
    return visit_source(volume.density, [&](const auto& source) { return f(PlainField{source}); });
  }
  const auto visit = [&](auto look_up, auto shared) -> decltype(auto) {
    return visit_squeeze<look_up>(squeeze_of(volume.density), [&](auto squeeze) -> decltype(auto) {
      return f(make_field<look_up, squeeze, shared>(volume.density));
    });
  };
  if (volume.density.shares_samples()) {
    return visit_closed_look_up(volume.density.look_up, [&](auto look_up) -> decltype(auto) {
      return visit(look_up, std::true_type{});
    });
  }
  return visit_look_up(volume.density.look_up, [&](auto look_up) -> decltype(auto) {
    return visit(look_up, std::false_type{});
  });
}

/// The trackers along a RayWalk: as along any other segments, with t from the ray's origin.
template <Tracker kTracker, class Field, class Numbers, class Count>
[[nodiscard]] Flight free_flight(RayWalk& walk, const Field& field, Numbers& rng, Count& count) {
  Flight flight = free_flight<kTracker>(walk.local(), field, rng, count);
  flight.t = flight.collided ? walk.world(flight.t) : flight.t;
  return flight;
}

template <Transmittance kEstimator, Tracker kTracker, class Field, class Numbers, class Count,
          class Control = MinorantControl>
[[nodiscard]] float transmittance(RayWalk& walk, const Field& field, Numbers& rng, Count& count,
                                  const Control& control = {}) {
  return transmittance<kEstimator, kTracker>(walk.local(), field, rng, count, control);
}

template <class Field, class Count>
[[nodiscard]] double optical_depth(RayWalk& walk, const Field& field, Count& count) {
  return optical_depth(walk.local(), field, count);
}

}  // namespace pvol
