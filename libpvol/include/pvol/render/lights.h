// Lights of a scene made ready for sampling.
#pragma once

#include <vector>

#include "pvol/math/rng.h"
#include "pvol/render/scene.h"
#include "pvol/volume/phase.h"

namespace pvol {

/// A direction towards a light with what comes from there.
struct LightSample {
  Vec3f direction;  ///< unit, from the scene
  Rgb radiance;     ///< for a delta sun: perpendicular irradiance, with pdf 1
  float pdf = 0;    ///< per steradian; 0: nothing to sample
};

/// The sky with importance sampling of pictures: pixels in proportion to luminance x solid angle.
/// A constant or gradient sky is found well enough by scattered rays and is not sampled.
class SkyLight {
 public:
  explicit SkyLight(const Environment& environment);

  [[nodiscard]] Rgb radiance(Vec3f direction) const;
  /// Whether `sample` is worth a shadow ray.
  [[nodiscard]] bool sampled() const { return !row_cdf_.empty(); }
  [[nodiscard]] LightSample sample(Rng& rng) const;
  /// Of a sky that is sampled: luminance averaged over all directions.
  [[nodiscard]] float mean_luminance() const { return mean_luminance_; }
  /// Density per steradian of `sample`; 0 for a sky that is not sampled.
  [[nodiscard]] float pdf(Vec3f direction) const;

 private:
  struct Pixel {
    int x, y;
  };
  [[nodiscard]] Pixel pixel_at(Vec3f direction) const;
  [[nodiscard]] float pixel_pdf(Pixel p) const;

  Environment environment_;
  Vec3f up_;                       // of a gradient
  double rotation_ = 0;            // of a picture, in turns
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
  Rgb radiance;                    ///< 0 for a delta sun
  float one_minus_cos_radius = 0;  ///< of the disc; 0: delta
  float pdf = 0;                   ///< 1 / solid angle; 0: delta

  explicit SunLight(const Sun& sun);
  [[nodiscard]] bool delta() const { return pdf == 0; }
  /// Whether a unit direction points into the disc.
  [[nodiscard]] bool hit(Vec3f d) const {
    return one_minus_cos(d, direction) < one_minus_cos_radius;
  }
  [[nodiscard]] LightSample sample(Rng& rng) const {
    return delta() ? LightSample{direction, irradiance, 1} : sample_disc(rng);
  }

 private:
  [[nodiscard]] LightSample sample_disc(Rng& rng) const;
};

}  // namespace pvol
