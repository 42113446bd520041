// The sky made ready for rays and for sampling.
#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "pvol/math/rng.h"
#include "pvol/render/light_sample.h"
#include "pvol/render/sky.h"

namespace pvol {

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

 private:
  struct Pixel {
    int x, y;
  };
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

}  // namespace pvol
