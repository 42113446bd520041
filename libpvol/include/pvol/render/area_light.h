// A rectangle that shines to one side.
#pragma once

#include <array>

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/render/light_group.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// Radiance that is the same all over a rectangle and in all directions on its front. It lets light
/// through: nothing of it is in the way.
struct AreaLight {
  static constexpr const char* kName = "area";
  Vec3d position{0, 0, 0};           ///< of its middle, in world units
  Vec3d direction{0, -1, 0};         ///< that its front faces; any length > 0
  std::array<double, 2> size{1, 1};  ///< width and height in world units, > 0
  Vec3d up{0, 1, 0};                 ///< which way its height lies; along the direction, any way
  Rgb radiance{1.0f};
  std::string group{};         ///< of lights that share a layer; "": the light has one to itself
  bool visible_camera = true;  ///< whether the camera sees its front
  friend bool operator==(const AreaLight&, const AreaLight&) = default;
};

template <std::same_as<AreaLight> T>
[[nodiscard]] constexpr auto keys(const T&) {
  return std::to_array<Key<T>>({
      key<&T::position>({.key = "position",
                         .metavar = "XYZ",
                         .limits = number().times(3),
                         .help = "Centre of the light, in world units",
                         .required = true}),
      key<&T::direction>({.key = "direction",
                          .metavar = "XYZ",
                          .limits = direction(),
                          .help = "Direction in which the front faces; the back emits nothing"}),
      {{.key = "size",
        .metavar = "W,H",
        .limits = number(Range::above(0)).times(2),
        .help = "Width and height in world units"},
       [](const T& t) {
         return Value(Value::List{t.size[0], t.size[1]});
       },
       [](T& t, const Value& v) {
         t.size = {*(*v.list())[0].number(), *(*v.list())[1].number()};
       }},
      key<&T::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "Direction of the height, projected onto the light's plane"}),
      key<&T::radiance>({.key = "radiance",
                         .metavar = "RGB",
                         .limits = number(kRadianceRange).or_three(),
                         .help = "Radiance of the front; a lamp of P watts has P / (pi * area)"}),
      key<&T::visible_camera>(
          {.key = "visible_camera",
           .help = "Whether the camera sees the light itself; it shines all the same"}),
      group_key<&T::group>(),
  });
}

}  // namespace pvol
