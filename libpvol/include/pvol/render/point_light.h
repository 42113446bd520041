// A light at a place in the scene: a point, or a ball.
#pragma once

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/render/light_group.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// Shines evenly in all directions, outside clouds or inside. No ray meets a point: light comes
/// from it by next-event estimation alone, whose variance has no bound where the medium touches the
/// light (THEORY.md, T5.6). A ball is met by rays; it lets light through.
struct PointLight {
  static constexpr const char* kName = "point";
  Vec3d position{0, 0, 0};  ///< in world units
  Rgb intensity{1.0f};      ///< irradiance at distance 1, in world units, of a plane that faces it
  std::string group{};      ///< of lights that share a layer; "": the light has one to itself
  double radius = 0;        ///< of a ball that shines outwards; 0: a point
  bool visible_camera = true;  ///< whether the camera sees the ball
  friend bool operator==(const PointLight&, const PointLight&) = default;
};

template <std::same_as<PointLight> T>
[[nodiscard]] constexpr auto keys(const T&) {
  return std::to_array<Key<T>>({
      key<&T::position>({.key = "position",
                         .metavar = "XYZ",
                         .limits = number().times(3),
                         .help = "Position of the light, in world units",
                         .required = true}),
      key<&T::intensity>({.key = "intensity",
                          .metavar = "RGB",
                          .limits = number(kRadianceRange).or_three(),
                          .help = "Irradiance at a distance of one world unit; it falls with the "
                                  "square of the distance"}),
      key<&T::radius>({.key = "radius",
                       .metavar = "X",
                       .limits = number(Range::at_least(0)),
                       .help = "Radius of a sphere that emits evenly, in world units; 0 is a "
                               "point, which is invisible"}),
      key<&T::visible_camera>(
          {.key = "visible_camera",
           .help = "Whether the camera sees the sphere itself; it shines all the same"}),
      group_key<&T::group>(),
  });
}

}  // namespace pvol
