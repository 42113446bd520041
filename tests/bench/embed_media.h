// A volume of pvol as a path tracer of another renderer may ask it: by segments and look-ups at
// points of the world, by segments and look-ups at t, or by whole flights.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "pvol/trackers.h"

namespace pvol::bench {

template <class Field>
inline constexpr bool kIsTrilinear = false;
template <class Field>
requires CellField<std::remove_cvref_t<Field>>
inline constexpr bool kIsTrilinear<Field> =
    std::remove_cvref_t<decltype(std::declval<Field>().source)>::kLookUp == LookUp::trilinear;

/// Free flights by decomposition tracking along the segments of a walk, written by an embedder:
/// exceeds(s, t, mu) says whether mu < mu_t at t.
template <class Segments, class Count, class Exceeds>
[[nodiscard]] double fly(Segments& walk, Rng& rng, Count& count, const Exceeds& exceeds) {
  double hit = std::numeric_limits<double>::infinity();
  (void)visit_tentative(walk, rng, count, [&](const Segment& s, double t, float u) {
    const float mu = u * s.hi;
    count.bounds_test();
    if (!(mu < s.lo) && !exceeds(s, t, mu)) return false;
    hit = t;
    return true;
  });
  return hit;
}

/// Ratio tracking; extinction(s, t) is mu_t at t.
template <class Segments, class Count, class Extinction>
[[nodiscard]] float pass(Segments& walk, Rng& rng, Count& count, const Extinction& extinction) {
  float weight = 1;
  const bool ended = visit_tentative(walk, rng, count, [&](const Segment& s, double t, float u) {
    weight *= std::max(0.0f, 1 - extinction(s, t) / s.hi);
    return !pvol::detail::survives(weight, u);
  });
  return ended ? 0.0f : weight;
}

/// What the media below share, which know how a walk begins (`begin`) and how mu_t is looked up on
/// the way (`exceeds`, `extinction`).
template <bool kAnalog, class Medium, class Count>
[[nodiscard]] double flight_of(const Medium& m, RayWalk& walk, const Ray& ray, Rng& rng,
                               Count& count) {
  return fly(walk, rng, count, [&](const Segment& s, double t, float mu) {
    return m.exceeds(walk, ray, s, t, mu, count);
  });
}

template <bool kAnalog, class Medium, class Count>
[[nodiscard]] float transmittance_of(const Medium& m, RayWalk& walk, const Ray& ray, Rng& rng,
                                     Count& count) {
  if constexpr (kAnalog) {
    return std::isfinite(flight_of<kAnalog>(m, walk, ray, rng, count)) ? 0.0f : 1.0f;
  }
  return pass(walk, rng, count,
              [&](const Segment& s, double t) { return m.extinction(walk, ray, s, t, count); });
}

/// Segments, and points of the world for everything else.
template <bool kAnalog>
struct SegmentsAndPoints {
  const Volume& volume;

  template <class Count>
  [[nodiscard]] float extinction(const RayWalk&, const Ray& ray, const Segment&, double t,
                                 Count& count) const {
    count.lookup();
    return extinction_at(volume, ray.at(t));
  }
  template <class Count>
  [[nodiscard]] bool exceeds(const RayWalk& walk, const Ray& ray, const Segment& s, double t,
                             float mu, Count& count) const {
    return mu < extinction(walk, ray, s, t, count);
  }

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count& count) const {
    auto walk = enter(volume, ray);
    if (!walk) return std::numeric_limits<double>::infinity();
    return flight_of<kAnalog>(*this, *walk, ray, rng, count);
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count& count) const {
    auto walk = enter(volume, ray);
    return walk ? transmittance_of<kAnalog>(*this, *walk, ray, rng, count) : 1;
  }
};

/// Segments, and look-ups at t of a segment by a field that was chosen once.
template <bool kAnalog, class Field>
struct SegmentsAndField {
  const Volume& volume;
  const Field& field;

  template <class Count>
  [[nodiscard]] float extinction(const RayWalk& walk, const Ray&, const Segment& s, double t,
                                 Count& count) const {
    return field.extinction(s, walk.point(t), count);
  }
  template <class Count>
  [[nodiscard]] bool exceeds(const RayWalk& walk, const Ray&, const Segment& s, double t, float mu,
                             Count& count) const {
    return field.exceeds(s, walk.point(t), mu, count);
  }

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count& count) const {
    auto walk = enter(volume, ray);
    if (!walk) return std::numeric_limits<double>::infinity();
    return flight_of<kAnalog>(*this, *walk, ray, rng, count);
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count& count) const {
    auto walk = enter(volume, ray);
    return walk ? transmittance_of<kAnalog>(*this, *walk, ray, rng, count) : 1;
  }
};

/// The same by a path that goes on, and casts its shadow rays, from where it collided.
template <bool kAnalog, class Field>
struct CursorsAndField : SegmentsAndField<kAnalog, Field> {
  std::optional<Cursor> here{};  ///< of the last collision

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count& count) {
    auto walk = begin(ray);
    if (!walk) return std::numeric_limits<double>::infinity();
    const double t = flight_of<kAnalog>(*this, *walk, ray, rng, count);
    if (std::isfinite(t)) here = walk->cursor_at(t);
    return t;
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count& count) const {
    auto walk = begin(ray);
    return walk ? transmittance_of<kAnalog>(*this, *walk, ray, rng, count) : 1;
  }

 private:
  [[nodiscard]] std::optional<RayWalk> begin(const Ray& ray) const {
    if (!here) return enter(this->volume, ray);
    return resume(this->volume, *here, ray.d);
  }
};

/// One call a ray.
template <bool kAnalog>
struct WholeFlights {
  static constexpr bool kCounts = false;
  const Volume& volume;

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count&) const {
    return sample_flight(volume, ray, std::numeric_limits<double>::infinity(), rng).t;
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count&) const {
    return sample_transmittance(volume, ray, std::numeric_limits<double>::infinity(), rng,
                                kAnalog ? Transmittance::analog : Transmittance::ratio);
  }
};

}  // namespace pvol::bench
