#include "render/light/sky/sun_beam.h"

#include <cmath>

#include "render/light/sky/air_ray.h"
#include "render/light/sky/angles.h"

namespace pvol::detail {
namespace {

Amounts column_towards(const Atmosphere& a, int level, double angle) {
  const AirRay ray(a, {level, angle, std::cos(angle), 1});
  Amounts sum;
  ray.cross([&](int from, int to, double begin, double end) {
    // Long ways through the thin shells at the ground, and ways down and up again, bend.
    const int parts = from == to ? 8 : 2;
    for (int i = 0; i < parts; ++i) {
      const double t0 = begin + (end - begin) * i / parts,
                   t1 = begin + (end - begin) * (i + 1) / parts;
      const Amounts c = column(ray, ray.amounts(t0), ray.amounts(t1), t0, t1);
      sum.molecules += c.molecules, sum.aerosols += c.aerosols, sum.ozone += c.ozone;
    }
  });
  return sum;
}

float mixed(float a, float b, float u) { return a + (b - a) * u; }

}  // namespace

SunBeam::SunBeam(const Atmosphere& a) : air_(a), columns_(kLevels.size() * kAngles) {
  for (int level = 0; level <= kTop; ++level) {
    const double h = kLevels[std::size_t(level)];
    const double sets = kPi - std::asin(a.planet / (a.planet + h));
    sets_[std::size_t(level)] = sets;
    for (int i = 0; i < kAngles; ++i) {
      const double u = double(i) / (kAngles - 1);
      // A ray that touches the ground is kept above it.
      const double angle = std::min(sets * (1 - u * u), sets - 1e-9);
      columns_[std::size_t(level * kAngles + i)] = column_towards(a, level, angle);
    }
  }
}

Spectrum SunBeam::at(int level, double sun_angle) const {
  const double sets = sets_[std::size_t(level)];
  if (sun_angle > sets) return {};
  const double place = std::sqrt(1 - std::max(sun_angle, 0.0) / sets) * (kAngles - 1);
  const int i = std::min(int(place), kAngles - 2);
  const float u = float(place - i);
  const Amounts& a = columns_[std::size_t(level * kAngles + i)];
  const Amounts& b = columns_[std::size_t(level * kAngles + i) + 1];
  return transmittance(
      extinction(air_, {mixed(a.molecules, b.molecules, u), mixed(a.aerosols, b.aerosols, u),
                        mixed(a.ozone, b.ozone, u)}));
}

Spectrum SunBeam::of_disc(double sun_angle, double radius) const {
  constexpr int kChords = 32;  // of equal angles about the centre
  Spectrum sum;
  float area = 0;
  for (int i = 0; i < kChords; ++i) {
    const double turn = kPi * (i + 0.5) / kChords;
    const auto width = float(std::sin(turn) * std::sin(turn));  // chord times its breadth
    sum.add(at(0, sun_angle - radius * std::cos(turn)), width);
    area += width;
  }
  return sum * (1 / area);
}

}  // namespace pvol::detail
