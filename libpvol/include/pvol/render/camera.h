// The camera.
#pragma once

#include <optional>

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/volume/shutter.h"

namespace pvol {

/// Perspective camera in world space; image x runs right, y runs down.
struct Camera {
  Vec3d position{0, 0, 0};
  Vec3d target{0, 0, -1};  ///< the point at the image's centre
  Vec3d up{0, 1, 0};       ///< must not be parallel to target - position
  double fov = 35;         ///< vertical field of view in degrees, in (0, 180)
  Shutter shutter{};       ///< in frames; of volumes that have velocities
  double fps = 24;         ///< frames per second
  friend bool operator==(const Camera&, const Camera&) = default;
};

/// Nothing of a shutter that opens before it closes.
[[nodiscard]] const char* expect_shutter(const Value& value);

template <std::same_as<Camera> C>
[[nodiscard]] constexpr auto keys(const C&) {
  return std::to_array<Key<C>>({
      key<&C::position>({.key = "position",
                         .metavar = "XYZ",
                         .limits = number().times(3),
                         .help = "Where the camera is, in world units",
                         .required = true}),
      key<&C::target>({.key = "target",
                       .metavar = "XYZ",
                       .limits = number().times(3),
                       .help = "The point at the image's centre",
                       .required = true}),
      key<&C::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "The direction that is up in the image"}),
      key<&C::fov>({.key = "fov",
                    .metavar = "DEGREES",
                    .limits = number(Range::open(0, 180)),
                    .help = "Vertical field of view in degrees"}),
      {{.key = "shutter",
        .metavar = "OPEN,CLOSE",
        .limits = number(Range::closed(-100, 100)).times(2).also(expect_shutter),
        .help = "Opening and closing in frames from the time of the files, e.g. [-0.25, 0.25]: "
                "clouds with velocities move in between; [0, 0] shows them still"},
       [](const C& c) {
         return Value(Value::List{c.shutter.open, c.shutter.close});
       },
       [](C& c, const Value& v) {
         c.shutter = {*(*v.list())[0].number(), *(*v.list())[1].number()};
       }},
      key<&C::fps>({.key = "fps",
                    .metavar = "X",
                    .limits = number(Range::closed(1e-3, 1e6)),
                    .help = "Frames per second, for velocities"}),
  });
}

/// A target where the camera is, or `up` along the view.
[[nodiscard]] std::optional<Misfit> misfit(const Camera& camera);

/// Throws Error for values out of range, alone or together.
void validate(const Camera& camera);

}  // namespace pvol
