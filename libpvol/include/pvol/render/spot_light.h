// A light of no extent that shines into a cone.
#pragma once

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/render/light_group.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// A point light within a cone, fading towards its rim by 3 x^2 - 2 x^3 of the cosine. No ray meets
/// it.
struct SpotLight {
  static constexpr const char* kName = "spot";
  Vec3d position{0, 0, 0};    ///< in world units
  Vec3d direction{0, -1, 0};  ///< that it shines along; any length > 0
  Rgb intensity{1.0f};        ///< irradiance at distance 1 on the axis of a plane that faces it
  double angle = 60;          ///< of the whole cone in degrees, in (0, 360]
  double blend = 0.15;        ///< share of the angle over which it fades, in [0, 1]
  std::string group{};        ///< of lights that share a layer; "": the light has one to itself
  friend bool operator==(const SpotLight&, const SpotLight&) = default;
};

template <std::same_as<SpotLight> T>
[[nodiscard]] constexpr auto keys(const T&) {
  return std::to_array<Key<T>>({
      key<&T::position>({.key = "position",
                         .metavar = "XYZ",
                         .limits = number().times(3),
                         .help = "Position of the light, in world units",
                         .required = true}),
      key<&T::direction>({.key = "direction",
                          .metavar = "XYZ",
                          .limits = direction(),
                          .help = "Direction of the axis, away from the light"}),
      key<&T::intensity>({.key = "intensity",
                          .metavar = "RGB",
                          .limits = number(kRadianceRange).or_three(),
                          .help = "Irradiance on the axis at a distance of one world unit; it "
                                  "falls with the square of the distance"}),
      key<&T::angle>({.key = "angle",
                      .metavar = "DEGREES",
                      .limits = number(Range::closed(0.01, 360)),
                      .help = "Full angle of the cone in degrees, from rim to rim"}),
      key<&T::blend>({.key = "blend",
                      .metavar = "X",
                      .limits = number(Range::closed(0, 1)),
                      .help = "Fraction of the angle over which the light fades towards the rim"}),
      group_key<&T::group>(),
  });
}

}  // namespace pvol
