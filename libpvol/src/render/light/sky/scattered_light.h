// Light that air and ground scatter, order by order, around one place of a planet.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/light/sky/air_path.h"
#include "render/light/sky/sun_beam.h"

namespace pvol::detail {

/// Radiance over the sun's irradiance above the air, per steradian, apart by what scattered last.
struct SkyLightParts {
  Spectrum molecules;  ///< straight from the sun, over the phase function
  Spectrum aerosols;   ///< the same
  Spectrum rest;       ///< all that was scattered more than once, or by the ground
};

/// Light that arrives at places, as scattering needs it: enough for any direction of it to leave.
struct Incident {
  static constexpr int kAngles = 17, kAzimuths = 9;  // evenly from 0 to pi
  Spectrum xx, yy, zz, xz;  ///< second moments of the radiance; x is towards the sun, z up
  Spectrum down, up;        ///< flux down and up
  /// Radiance averaged by the aerosols' phase function about each direction of flight.
  std::array<Spectrum, kAngles * kAzimuths> by_aerosols;
};

/// What molecules scatter towards a direction of the components x and z by these factors of the
/// moments.
struct MomentFactors {
  float xx, yy, zz, xz;
};
[[nodiscard]] MomentFactors scattered_towards(double x, double z);

/// Light of all orders in air that one sun shines on, by levels and by the sun's angle around that
/// at one place (THEORY.md, T5.16).
class ScatteredLight {
 public:
  /// The sun's angle from the zenith at the place, radians. The atmosphere must outlive this.
  ScatteredLight(const Atmosphere& a, double sun_angle);

  /// Along rays from the ground at the place: their angle from the zenith, at most pi/2, and their
  /// azimuths from the sun's, 0 to pi.
  [[nodiscard]] std::vector<SkyLightParts> seen(double angle,
                                                std::span<const double> azimuths) const;
  /// Flux down less flux up, of scattered light, at a level above the place.
  [[nodiscard]] Spectrum net_flux(int level) const;
  [[nodiscard]] const SunBeam& beam() const { return beam_; }
  [[nodiscard]] int orders() const { return orders_; }

 private:
  struct Mix {
    std::size_t at;  // the node before
    float u;         // share of the next
  };
  [[nodiscard]] Mix mix(double sun_angle) const;
  [[nodiscard]] std::size_t node(std::size_t sun, int level) const {
    return sun * kLevels.size() + std::size_t(level);
  }
  void follow_order(bool first);
  void collect(std::size_t sun, int level, bool first, Incident& to) const;
  [[nodiscard]] Spectrum radiance(const AirPath& path, const AirPlace& from, bool first) const;
  [[nodiscard]] ByMatter direct(const AirPlace& p, double to_sun) const;
  [[nodiscard]] ByMatter diffuse(const std::vector<Incident>& light, const AirPlace& p) const;
  [[nodiscard]] Spectrum from_ground(double sun_angle, bool first) const;
  void sum_up();

  const Atmosphere& air_;
  double at_;  // the sun's angle at the place
  SunBeam beam_;
  std::vector<double> suns_;          // angles of the sun, ascending
  std::vector<Incident> last_, all_;  // of the last order, and of all so far; by sun, then by level
  std::vector<AirPath> paths_;        // of the rays of `collect`, by level and cosine
  std::vector<float> kernel_;         // of aerosols: from the rays of `collect` to Incident's
  int orders_ = 0;
};

}  // namespace pvol::detail
