// The sun. A light of a scene has its name, which is that of its sections in scene files, and its
// keys beside it; see Light in scene.h.
#pragma once

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/render/light_group.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// A distant light of uniform radiance over a disc in the sky.
struct Sun {
  static constexpr const char* kName = "sun";
  Vec3d direction{0, 1, 0};  ///< from the scene towards the sun; any length > 0
  Rgb irradiance{3.0f};      ///< on a plane perpendicular to `direction`, outside the cloud
  double angle = 0;          ///< angular diameter in degrees, 0 (a delta light) or in [0.01, 180)
  std::string group{};       ///< of lights that share a layer; "": the light has one to itself
  friend bool operator==(const Sun&, const Sun&) = default;
};

/// Discs of a size that float directions do not resolve are taken for mistakes.
[[nodiscard]] inline const char* expect_disc(const Value& angle) {
  const double degrees = *angle.number();
  return degrees == 0 || degrees >= 0.01 ? nullptr : "0 or a number in [0.01, 180)";
}

template <std::same_as<Sun> T>
[[nodiscard]] constexpr auto keys(const T&) {
  return std::to_array<Key<T>>({
      key<&T::direction>({.key = "direction",
                          .metavar = "XYZ",
                          .limits = direction(),
                          .help = "Direction from the scene towards the sun"}),
      key<&T::irradiance>({.key = "irradiance",
                           .metavar = "RGB",
                           .limits = number(kRadianceRange).or_three(),
                           .help = "Irradiance of a plane that faces the sun"}),
      key<&T::angle>({.key = "angle",
                      .metavar = "DEGREES",
                      .limits = number(Range::half_open(0, 180)).also(expect_disc),
                      .help = "Angular diameter of the disc in degrees, 0 or at least 0.01"}),
      group_key<&T::group>(),
  });
}

}  // namespace pvol
