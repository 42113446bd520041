// Lights of a scene made ready for sampling.
#pragma once

#include <limits>
#include <span>
#include <variant>
#include <vector>

#include "pvol/math/box.h"
#include "pvol/math/direction.h"
#include "pvol/math/rng.h"
#include "pvol/render/scene.h"

namespace pvol {

/// A direction towards a light with what comes from there.
struct LightSample {
  Vec3f direction;  ///< unit, from the scene
  Rgb radiance;     ///< of a delta light: irradiance of a plane that faces it
  float pdf = 0;    ///< per steradian; 0 of a delta light, which no ray meets by chance
  double distance = std::numeric_limits<double>::infinity();  ///< to the light, world units
};

/// The sky with importance sampling of pictures: pixels in proportion to luminance x solid angle.
/// A constant or gradient sky is found well enough by scattered rays and is not sampled.
class SkyLight {
 public:
  explicit SkyLight(const Environment& environment);

  [[nodiscard]] Rgb radiance(Vec3f direction) const;
  [[nodiscard]] bool is_constant() const {
    return std::holds_alternative<ConstantSky>(environment_);
  }
  /// Whether `sample` is worth a shadow ray.
  [[nodiscard]] bool sampled() const { return !row_cdf_.empty(); }
  [[nodiscard]] LightSample sample(Rng& rng) const;
  /// Of a sky that is sampled: luminance averaged over all directions.
  [[nodiscard]] float mean_luminance() const { return mean_luminance_; }
  /// Density per steradian of `sample`; 0 for a sky that is not sampled.
  [[nodiscard]] float pdf(Vec3f direction) const;

  /// visit(unit direction, radiance, solid angle) for patches of the sky, at least 512 x 256 of
  /// them and one for each pixel of a picture.
  template <class Visit>
  void visit_patches(const Visit& visit) const {
    const auto [width, height] = patches();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const Vec3f d = direction_at((x + 0.5) / width, (y + 0.5) / height);
        visit(Vec3d(d), radiance(d), solid_angle(double(y) / height, (y + 1.0) / height) / width);
      }
    }
  }

 private:
  struct Pixel {
    int x, y;
  };
  [[nodiscard]] Pixel patches() const;
  [[nodiscard]] Vec3f direction_at(double across, double down) const;
  [[nodiscard]] static double solid_angle(double top, double bottom);
  [[nodiscard]] Pixel pixel_at(Vec3f direction) const;
  [[nodiscard]] float pixel_pdf(Pixel p) const;

  Environment environment_;
  Vec3f up_;                       // of a gradient
  double rotation_ = 0;            // of a picture, in turns
  bool turned_ = false;            // whether a picture's upper edge is not +y
  Vec3f x_, y_, z_;                // its axes in the world, where it is turned
  std::vector<double> row_cdf_;    // height + 1 values from 0 to 1
  std::vector<double> pixel_cdf_;  // for each row width + 1 values from 0 to 1
  float mean_luminance_ = 0;
  std::vector<double> row_y_;  // height + 1 values of cos(theta) at the rows' borders
};

/// A sun with its constants. A disc below 7e-6 degrees, which float directions do not resolve, is a
/// delta sun too.
struct SunLight {
  Vec3f direction;  ///< unit, towards the sun
  Rgb irradiance;
  Rgb disc_radiance;               ///< 0 for a delta sun
  float one_minus_cos_radius = 0;  ///< of the disc; 0: delta
  float disc_pdf = 0;              ///< 1 / solid angle; 0: delta

  explicit SunLight(const Sun& sun);

  // The questions that every light answers. Directions are unit.

  /// Radiance that a ray meets which has left everything in this direction.
  [[nodiscard]] Rgb seen(Vec3f d) const {
    return one_minus_cos(d, direction) < one_minus_cos_radius ? disc_radiance : Rgb(0.0f);
  }
  /// Density of `sample` where `seen` is not 0.
  [[nodiscard]] float pdf() const { return disc_pdf; }
  /// Light that arrives at where(), a place in the world.
  template <class Where>
  [[nodiscard]] LightSample sample(const Where&, Rng& rng) const {
    return disc_pdf == 0 ? LightSample{direction, irradiance} : sample_disc(rng);
  }
  /// About the irradiance in a box of the world, on planes that face the light.
  [[nodiscard]] Rgb irradiance_on(const Box&) const { return irradiance; }
  /// Irradiance of a plane with this unit normal at a place, with nothing in between.
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;

 private:
  [[nodiscard]] LightSample sample_disc(Rng& rng) const;
};

/// A point light, with the questions that every light answers.
struct PointSource {
  Vec3d position;
  Rgb intensity;

  [[nodiscard]] static Rgb seen(Vec3f) { return Rgb(0.0f); }
  [[nodiscard]] static constexpr float pdf() { return 0; }
  template <class Where>
  [[nodiscard]] LightSample sample(const Where& where, Rng&) const {
    return arriving_at(where());
  }
  /// That at the centre of the box or, where the light is nearer to it than the corners are, that
  /// at the corners' distance.
  [[nodiscard]] Rgb irradiance_on(const Box& box) const;
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;

 private:
  [[nodiscard]] LightSample arriving_at(Vec3d place) const;
};

/// The lights of a scene, ready for sampling: each a member of its own kind. To add one, see
/// libpvol/ROOMS.md.
using LightSource = std::variant<SunLight, PointSource>;
[[nodiscard]] std::vector<LightSource> make_light_sources(std::span<const Light> lights);

/// Throws Error, which says what is wrong, for values out of range.
void validate(const Light& light);

}  // namespace pvol
