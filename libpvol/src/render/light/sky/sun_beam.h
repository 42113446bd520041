// The sun's direct light in the air.
#pragma once

#include <array>
#include <vector>

#include "render/light/sky/atmosphere.h"

namespace pvol::detail {

/// Amounts between the levels and the sun, a table by its angle from the zenith that is dense
/// towards where it sets behind the planet.
class SunBeam {
 public:
  explicit SunBeam(const Atmosphere& a);

  /// Transmittance from above the air to a level, of a point of the sun at this angle from the
  /// zenith there, in radians; 0 in the planet's shadow.
  [[nodiscard]] Spectrum at(int level, double sun_angle) const;

  /// At the ground, averaged over a disc of this radius in radians, part of which may have set.
  [[nodiscard]] Spectrum of_disc(double sun_angle, double radius) const;

 private:
  static constexpr int kAngles = 128;
  const Atmosphere& air_;
  std::array<double, kLevels.size()> sets_{};  // angle at which the sun sets
  std::vector<Amounts> columns_;               // by level, then by angle
};

}  // namespace pvol::detail
