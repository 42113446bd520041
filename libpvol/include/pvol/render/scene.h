// What a picture is made of besides its volumes: camera, lights and the options of the estimator.
// Plain values: scene files and tools fill them, `render` reads them.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/affine.h"
#include "pvol/math/names.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Perspective camera in world space; image x runs right, y runs down.
struct Camera {
  Vec3d position{0, 0, 0};
  Vec3d target{0, 0, -1};  ///< the point at the image's centre
  Vec3d up{0, 1, 0};       ///< must not be parallel to target - position
  double fov = 35;         ///< vertical field of view in degrees, in (0, 180)
  friend bool operator==(const Camera&, const Camera&) = default;
};

/// The same radiance from every direction.
struct ConstantSky {
  Rgb radiance{0.5f};
  friend bool operator==(const ConstantSky&, const ConstantSky&) = default;
};

/// Radiance by height: from ground through horizon to zenith, mixed linearly in |cos| of the angle
/// to `up`.
struct GradientSky {
  Rgb zenith{0.06f, 0.16f, 0.42f};
  Rgb horizon{0.32f, 0.46f, 0.66f};
  Rgb ground{0.16f, 0.16f, 0.15f};
  Vec3d up{0, 1, 0};
  friend bool operator==(const GradientSky&, const GradientSky&) = default;
};

/// A latitude-longitude picture around the scene. Pixel (x, y) covers azimuth 2 pi (x + [0,1]) /
/// width and angle pi (y + [0,1]) / height from +y; azimuth 0 looks along +x, pi/2 along +z.
/// Radiance is constant in each pixel, finite and not negative.
struct ImageSky {
  int width = 0, height = 0;
  std::vector<Rgb> pixels;  ///< rows from the top, width * height
  Rgb scale{1.0f};          ///< factor on every pixel
  double rotation = 0;      ///< degrees, added to the azimuth of the picture about +y
  friend bool operator==(const ImageSky&, const ImageSky&) = default;
};

using Environment = std::variant<ConstantSky, GradientSky, ImageSky>;

/// A distant light of uniform radiance over a disc in the sky.
struct Sun {
  Vec3d direction{0, 1, 0};  ///< from the scene towards the sun; any length > 0
  Rgb irradiance{3.0f};      ///< on a plane perpendicular to `direction`, outside the cloud
  double angle = 0;          ///< angular diameter in degrees, 0 (a delta light) or in [0.01, 180)
  friend bool operator==(const Sun&, const Sun&) = default;
};

/// Whether camera rays test a cloud's shell before its octree, where there is a shell.
enum class ShellUse {
  automatic,  ///< where an estimate for this camera says that it saves time
  on,
  off,
};
[[nodiscard]] constexpr auto names(ShellUse) {
  return std::to_array<Named<ShellUse>>({
      {ShellUse::automatic, "auto"},
      {ShellUse::on, "on"},
      {ShellUse::off, "off"},
  });
}

/// Whether paths are ended, split and turned by a coarse estimate of the light that they may meet,
/// made before the picture: much less noise in thick, bright clouds, and the same picture on
/// average (THEORY.md, T5.5).
enum class GuideUse {
  automatic,  ///< where it should pay, see choose_guide
  on,
  off,
};
[[nodiscard]] constexpr auto names(GuideUse) {
  return std::to_array<Named<GuideUse>>({
      {GuideUse::automatic, "auto"},
      {GuideUse::on, "on"},
      {GuideUse::off, "off"},
  });
}

struct RenderOptions {
  int width = 640, height = 480;
  int crop_x = 0, crop_y = 0;           ///< upper left corner of the part that is rendered
  int crop_width = 0, crop_height = 0;  ///< 0: up to the image's edge
  std::uint32_t samples = 64;           ///< camera samples per pixel
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one for each hardware thread
  Tracker tracker = Tracker::decomposition;
  Transmittance transmittance = Transmittance::automatic;
  MicroBoundsUse micro_bounds = MicroBoundsUse::automatic;
  LookUp look_up = LookUp::trilinear;
  ShellUse shells = ShellUse::automatic;
  GuideUse guide = GuideUse::automatic;
  std::optional<int> depth;  ///< octree depth at which the walk stops, 0..16; else by cost
  /// Factor on majorants, for measurements: above 1 bounds get looser and the picture stays the
  /// same; below 1, down to 1/3, they do not bound, which takes a tracker with weights.
  double majorant_scale = 1;
  /// Makes images biased: nodes of the octree that can change the optical depth of a ray through
  /// them by no more than this count as homogeneous (homogenise.h).
  std::optional<double> homogenise;
  /// Makes images biased: how often the grid is to be coarsened (coarsen.h) before make_volume,
  /// which takes it as it is.
  int preview = 0;
  std::optional<std::uint32_t> max_bounces;  ///< scatterings per path; a limit makes images biased
  bool background = true;  ///< whether camera rays see the lights behind the cloud
  bool count = false;      ///< count look-ups and the like (slower by a few per cent)
  friend bool operator==(const RenderOptions&, const RenderOptions&) = default;
};

/// Lights besides the environment.
using Light = std::variant<Sun>;

/// What surrounds volumes, and how they are rendered.
struct Scene {
  Camera camera;
  Environment environment = GradientSky{};
  std::vector<Light> lights;
  RenderOptions options;
  friend bool operator==(const Scene&, const Scene&) = default;
};

}  // namespace pvol
