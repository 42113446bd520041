// The camera. Which rays it has: src/render/scene/projection.h.
#pragma once

#include <array>
#include <optional>

#include "pvol/math/box.h"
#include "pvol/math/keys.h"
#include "pvol/math/moving_map.h"
#include "pvol/math/names.h"
#include "pvol/math/vec.h"
#include "pvol/volume/shutter.h"

namespace pvol {

enum class CameraKind {
  perspective,
  orthographic,  ///< rays are parallel
  latlong,       ///< all directions: longitude across, latitude down, the target in the middle
};
[[nodiscard]] constexpr auto names(CameraKind) {
  return std::to_array<Named<CameraKind>>({{CameraKind::perspective, "perspective"},
                                           {CameraKind::orthographic, "orthographic"},
                                           {CameraKind::latlong, "latlong"}});
}

/// The side of the picture that a sensor's size is told of.
enum class SensorFit {
  automatic,  ///< the longer one
  horizontal,
  vertical,
};
[[nodiscard]] constexpr auto names(SensorFit) {
  return std::to_array<Named<SensorFit>>({{SensorFit::automatic, "auto"},
                                          {SensorFit::horizontal, "horizontal"},
                                          {SensorFit::vertical, "vertical"}});
}

/// Where a camera is, and where it looks.
struct CameraPlace {
  Vec3d position{0, 0, 0};
  Vec3d target{0, 0, -1};
  Vec3d up{0, 1, 0};
  friend bool operator==(const CameraPlace&, const CameraPlace&) = default;
};

/// Camera in world space; image x runs right, y runs down.
struct Camera {
  Vec3d position{0, 0, 0};
  Vec3d target{0, 0, -1};  ///< the point at the image's centre, but for a shift
  Vec3d up{0, 1, 0};       ///< must not be parallel to target - position
  double fov = 35;         ///< vertical field of view in degrees, in (0, 180)
  Shutter shutter{};       ///< in frames, of all that moves
  double fps = 24;         ///< frames per second
  CameraKind kind = CameraKind::perspective;
  /// In mm; takes the place of fov, with the sensor's size in mm along the side that `fit` says.
  std::optional<double> focal_length{};
  double sensor = 36;
  SensorFit fit = SensorFit::automatic;
  /// What the sensor is moved by, right and up, over its size along that side; for pictures of
  /// which the target is not in the middle.
  std::array<double, 2> shift{0, 0};
  double ortho_scale = 1;  ///< world units along that side; orthographic
  /// Focal length over the lens' diameter; none: everything is sharp. The lens has the focal length
  /// or that of the field of view, in world units of `metres` metres.
  std::optional<double> f_stop{};
  std::optional<double> focus_distance{};  ///< along the view in world units; none: the target's
  double metres = 1;                       ///< of a world unit
  /// Where it is a frame later: it moves there evenly, and turns the shortest way, while the
  /// shutter is open (THEORY.md, T1.7); none: it stands still.
  std::optional<CameraPlace> to{};
  // Of a camera that frames the clouds by itself: from where, in degrees, and how near.
  double azimuth = 0;  ///< about up, against the clock from above; 0: from the front, +z
  /// Of the camera above the clouds, in [-90, 90]; none: a little, 0.12 over the distance.
  std::optional<double> elevation{};
  double zoom = 1;  ///< 2: the clouds are twice as large in the picture
  friend bool operator==(const Camera&, const Camera&) = default;
};

/// Half the picture's height over the distance; of an orthographic camera in world units.
[[nodiscard]] double half_height(const Camera& camera, double aspect);

/// The shift in the same unit.
[[nodiscard]] std::array<double, 2> shift_of(const Camera& camera, double aspect);

/// Radius of the lens in world units; 0: none.
[[nodiscard]] double lens_radius(const Camera& camera, double aspect);

/// What takes the camera from where it is at time 0 to where it is at others, in frames, and all
/// that it sees along; nothing of one that stands still. For valid cameras.
[[nodiscard]] std::optional<MovingMap> motion_of(const Camera& camera);

/// The camera as it is at a time, in frames, where it stands still. Its focus has moved along.
[[nodiscard]] Camera camera_at(const Camera& camera, double frames);

/// In the middle of the shutter: depths are along its axis.
[[nodiscard]] inline Camera middle_camera(const Camera& camera) {
  return camera_at(camera, camera.shutter.at(0.5));
}

/// Position, target and up of a 4x4 matrix that takes the camera's space to the world: it looks
/// along its -z, with y up. Either with the place in the last column, row by row, as Blender prints
/// Camera.matrix_world, or in the last row, as Houdini's worldTransform(); where the place is the
/// origin, it is taken as the former. Scales do not count. Nothing of one that is not affine or has
/// no volume.
[[nodiscard]] std::optional<CameraPlace> camera_place(const std::array<double, 16>& matrix);
/// Sets those; whether there are any.
bool place(Camera& camera, const std::array<double, 16>& matrix);
bool place(CameraPlace& camera, const std::array<double, 16>& matrix);

// What scenes may say, or null: a shutter that opens before it closes, a matrix that camera_place
// takes.
[[nodiscard]] const char* expect_shutter(const Value& value);
[[nodiscard]] const char* expect_matrix(const Value& value);

/// Of what has a place, by a list of 16 numbers.
template <class C>
void assign_camera_matrix(C& c, const Value& v) {
  std::array<double, 16> m{};
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = *(*v.list())[i].number();
  (void)place(c, m);
}

template <std::same_as<CameraPlace> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      key<&P::position>({.key = "position",
                         .metavar = "XYZ",
                         .limits = number().times(3),
                         .help = "Position of the camera one frame later, in world units"}),
      key<&P::target>({.key = "target",
                       .metavar = "XYZ",
                       .limits = number().times(3),
                       .help = "Point at the image's centre then"}),
      key<&P::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "Direction that is up in the image then"}),
      {{.key = "matrix",
        .metavar = "M",
        .limits = number().times(16).also(expect_matrix),
        .help = "Replaces position, target and up: the camera-to-world matrix of the next frame",
        .otherwise = "none"},
       [](const P&) { return Value(); },  // it is written as position, target and up
       &assign_camera_matrix<P>},
  });
}

template <std::same_as<Camera> C>
[[nodiscard]] constexpr auto keys(const C&) {
  return std::to_array<Key<C>>({
      key<&C::position>({.key = "position",
                         .metavar = "XYZ",
                         .limits = number().times(3),
                         .help = "Position of the camera, in world units",
                         .required = true}),
      key<&C::target>({.key = "target",
                       .metavar = "XYZ",
                       .limits = number().times(3),
                       .help = "Point at the image's centre",
                       .required = true}),
      key<&C::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "Direction that is up in the image"}),
      {{.key = "matrix",
        .metavar = "M",
        .limits = number().times(16).also(expect_matrix),
        .help = "Replaces position, target and up: the camera-to-world matrix, 16 numbers by rows, "
                "as Blender (matrix_world) and Houdini (worldTransform) print it; the camera looks "
                "along -z, y is up",
        .otherwise = "none"},
       [](const C&) { return Value(); },  // it is written as position, target and up
       &assign_camera_matrix<C>},
      key<&C::kind>({.key = "projection", .help = "Projection of the camera"}),
      key<&C::fov>({.key = "fov",
                    .metavar = "DEGREES",
                    .limits = number(Range::open(0, 180)),
                    .help = "Vertical field of view of a perspective camera, in degrees"}),
      key<&C::focal_length>({.key = "focal_length",
                             .metavar = "MM",
                             .limits = number(Range::above(0)).or_word("none"),
                             .help = "Replaces fov: focal length of the lens in mm",
                             .otherwise = "none"}),
      key<&C::sensor>({.key = "sensor",
                       .metavar = "MM",
                       .limits = number(Range::above(0)),
                       .help = "Size of the sensor in mm, for focal_length"}),
      key<&C::fit>({.key = "sensor_fit",
                    .help = "Side of the picture to which sensor, ortho_scale and shift refer; "
                            "auto is the longer one, as in Blender; Houdini uses horizontal"}),
      {{.key = "shift",
        .metavar = "X,Y",
        .limits = number(Range::closed(-100, 100)).times(2),
        .help = "Shift of the sensor to the right and up, as a fraction of its size, as in "
                "Blender; it moves the target away from the centre"},
       [](const C& c) {
         return Value(Value::List{c.shift[0], c.shift[1]});
       },
       [](C& c, const Value& v) {
         c.shift = {*(*v.list())[0].number(), *(*v.list())[1].number()};
       }},
      key<&C::ortho_scale>({.key = "ortho_scale",
                            .metavar = "X",
                            .limits = number(Range::above(0)),
                            .help = "World units along the side chosen by sensor_fit, for an "
                                    "orthographic camera with a position"}),
      key<&C::f_stop>({.key = "f_stop",
                       .metavar = "N",
                       .limits = number(Range::above(0)).or_word("none"),
                       .help = "Focal length over the diameter of the lens; smaller numbers blur "
                               "what is not at focus_distance more",
                       .otherwise = "none"}),
      key<&C::focus_distance>(
          {.key = "focus_distance",
           .metavar = "X",
           .limits = number(Range::above(0)).or_word("none"),
           .help = "Distance along the viewing direction that is in focus, in world units",
           .otherwise = "none: the target's"}),
      key<&C::metres>(
          {.key = "metres",
           .metavar = "X",
           .limits = number(Range::above(0)),
           .help = "Length of a world unit in metres, which sets the size of the lens"}),
      key<&C::azimuth>(
          {.key = "azimuth",
           .metavar = "DEGREES",
           .limits = number(Range::closed(-360, 360)),
           .help = "For a camera without position, which frames the clouds: direction from which "
                   "it looks, in degrees about up; 0 is the front, +z, and 90 the right, +x"}),
      key<&C::elevation>(
          {.key = "elevation",
           .metavar = "DEGREES",
           .limits = number(Range::closed(-90, 90)).or_word("none"),
           .help = "For a camera without position: its elevation above the clouds in degrees",
           .otherwise = "none: 6.8, a little above"}),
      key<&C::zoom>(
          {.key = "zoom",
           .metavar = "X",
           .limits = number(Range::closed(1e-3, 1e3)),
           .help = "For a camera without position: their size in the picture; 1 fits all in it"}),
      {{.key = "shutter",
        .metavar = "OPEN,CLOSE",
        .limits = number(Range::closed(-100, 100)).times(2).also(expect_shutter),
        .help = "Opening and closing times in frames, relative to the files' time, e.g. [-0.25, "
                "0.25]; clouds with velocities and all that has a `to` move in between, and [0, 0] "
                "keeps them still"},
       [](const C& c) {
         return Value(Value::List{c.shutter.open, c.shutter.close});
       },
       [](C& c, const Value& v) {
         c.shutter = {*(*v.list())[0].number(), *(*v.list())[1].number()};
       }},
      key<&C::fps>({.key = "fps",
                    .metavar = "X",
                    .limits = number(Range::closed(1e-3, 1e6)),
                    .help = "Frames per second, by which velocities are converted"}),
  });
}

/// A target where the camera is, `up` along the view, and what goes with another kind only; of its
/// way, a half turn, which might go either way. Keys of the latter are those of CameraPlace.
[[nodiscard]] std::optional<Misfit> misfit(const Camera& camera);
[[nodiscard]] std::optional<Misfit> misfit_of_way(const Camera& camera);

/// Throws Error for values out of range, alone or together.
void validate(const Camera& camera);

/// A camera that looks at `world_box` with all of it in view and all else as `like` has it: its
/// kind, `up`, lens and field of view, from its azimuth and elevation, and then by its zoom. The
/// front is where z is largest or, where z is up, y least. Straight from above or below the front
/// is down or up in the picture.
[[nodiscard]] Camera frame(const Box& world_box, double aspect, const Camera& like = {});

}  // namespace pvol
