// Straight rays through shells of air.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "render/light/sky/atmosphere.h"

namespace pvol::detail {

/// acos(x) within 3e-8 (Abramowitz and Stegun 1964, 4.4.46), which takes a fraction of its time.
[[nodiscard]] inline double arc_cosine(double x) {
  constexpr std::array<double, 8> kTerms{1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                                         0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
  const double y = std::abs(x);
  double sum = 0;
  for (std::size_t i = kTerms.size(); i-- > 0;) sum = sum * y + kTerms[i];
  const double angle = std::sqrt(std::fmax(1 - y, 0)) * sum;
  return x < 0 ? std::numbers::pi - angle : angle;
}

/// A place on a ray: at a level, the sun and the ray seen from there.
struct AirPlace {
  int level;
  double sun_angle;    ///< from the zenith, radians
  double cosine;       ///< of the angle from the zenith to the ray's direction
  double cos_azimuth;  ///< of the angle about the zenith from the sun to the ray's direction
};

/// A ray from a level, about the planet's centre. Where it crosses levels, and what lies between.
class AirRay {
 public:
  AirRay(const Atmosphere& a, const AirPlace& from)
      : air_(a),
        from_(from),
        r_(a.planet + kLevels[std::size_t(from.level)]),
        cosine_(from.cosine),
        sun_up_(std::cos(from.sun_angle)),
        sun_side_(std::sin(from.sun_angle)),
        side_(std::sqrt(1 - from.cosine * from.cosine) * from.cos_azimuth) {}

  /// Cosine of the angle between the ray's direction and that to the sun.
  [[nodiscard]] double to_sun() const { return cosine_ * sun_up_ + side_ * sun_side_; }

  [[nodiscard]] const AirPlace& start() const { return from_; }

  /// Calls step(from level, to level, begin, end) for the way through each shell in turn, in km;
  /// whether it ends on the ground.
  template <class Step>
  bool cross(const Step& step) const {
    double t = 0;
    int k = from_.level;
    if (cosine_ < 0) {
      for (double half; k > 0 && (half = square_half(k - 1)) > 0; --k) {
        const double next = -r_ * cosine_ - std::sqrt(half);
        step(k, k - 1, t, next);
        t = next;
      }
      if (k == 0) return true;
      const double next = -r_ * cosine_ + std::sqrt(square_half(k));
      step(k, k, t, next);
      t = next;
    }
    for (; k < kTop; ++k) {
      const double next = -r_ * cosine_ + std::sqrt(square_half(k + 1));
      step(k, k + 1, t, next);
      t = next;
    }
    return false;
  }

  /// At this distance, which is where the ray crosses the level.
  [[nodiscard]] AirPlace at(int level, double t) const {
    const double r = air_.planet + kLevels[std::size_t(level)];
    const double sun = clamped((t * to_sun() + r_ * sun_up_) / r);
    const double up = clamped((t + r_ * cosine_) / r);
    const double sides = std::sqrt((1 - sun * sun) * (1 - up * up));
    const double azimuth = sides > 0 ? clamped((to_sun() - sun * up) / sides) : 1;
    return {level, arc_cosine(sun), up, azimuth};
  }

  /// Amounts at this distance.
  [[nodiscard]] Amounts amounts(double t) const {
    const double rise = t * (t + 2 * r_ * cosine_);  // of the squared radius
    const double r = std::sqrt(r_ * r_ + rise);
    return amounts_at(air_, kLevels[std::size_t(from_.level)] + rise / (r + r_));
  }

 private:
  [[nodiscard]] static double clamped(double c) { return std::fmax(-1, std::fmin(1, c)); }
  /// Of the half of the chord within a level's sphere.
  [[nodiscard]] double square_half(int level) const {
    const double h = kLevels[std::size_t(level)], from = kLevels[std::size_t(from_.level)];
    return (h - from) * (2 * air_.planet + h + from) + r_ * r_ * cosine_ * cosine_;
  }

  const Atmosphere& air_;
  AirPlace from_;
  double r_, cosine_, sun_up_, sun_side_, side_;
};

/// Amounts along a part of a ray times its length, by Simpson's rule; `ends` are those at its ends.
[[nodiscard]] inline Amounts column(const AirRay& ray, const Amounts& begin, const Amounts& end,
                                    double t0, double t1) {
  const Amounts middle = ray.amounts(0.5 * (t0 + t1));
  const float sixth = float(t1 - t0) / 6;
  return {(begin.molecules + 4 * middle.molecules + end.molecules) * sixth,
          (begin.aerosols + 4 * middle.aerosols + end.aerosols) * sixth,
          (begin.ozone + 4 * middle.ozone + end.ozone) * sixth};
}

}  // namespace pvol::detail
