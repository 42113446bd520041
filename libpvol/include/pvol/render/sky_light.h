// The sky made ready for rays and for sampling.
#pragma once

#include <memory>
#include <variant>

#include "pvol/math/color_space.h"
#include "pvol/math/rng.h"
#include "pvol/render/light_sample.h"
#include "pvol/render/sky.h"
#include "pvol/render/sky_picture.h"

namespace pvol {

/// The sky with importance sampling of pictures: pixels in proportion to luminance x solid angle.
/// A constant or gradient sky is found well enough by scattered rays and is not sampled. Copies
/// share the picture.
class SkyLight {
  using Picture = std::shared_ptr<const SkyPicture>;

 public:
  /// A clear sky is computed here, in this space; its sun is not of it, see lighting.h.
  explicit SkyLight(const Environment& environment, ColorSpace space = ColorSpace::rec709);
  explicit SkyLight(SkyPicture picture);

  [[nodiscard]] Rgb radiance(Vec3f direction) const;
  [[nodiscard]] bool is_constant() const { return std::holds_alternative<ConstantSky>(sky_); }
  /// Whether `sample` is worth a shadow ray.
  [[nodiscard]] bool sampled() const { return picture() != nullptr && picture()->sampled(); }
  /// Null for a constant or gradient sky.
  [[nodiscard]] const SkyPicture* picture() const {
    const Picture* shared = std::get_if<Picture>(&sky_);
    return shared != nullptr ? shared->get() : nullptr;
  }
  /// Of a sky that is sampled.
  [[nodiscard]] LightSample sample(Rng& rng) const { return picture()->sample(rng); }
  /// Of a sky that is sampled: luminance averaged over all directions.
  [[nodiscard]] float mean_luminance() const {
    return picture() != nullptr ? picture()->mean_luminance() : 0.0f;
  }
  /// The largest of any direction.
  [[nodiscard]] float largest_luminance() const {
    return picture() != nullptr ? picture()->largest_luminance() : 0.0f;
  }
  /// Density per steradian of `sample`; 0 for a sky that is not sampled.
  [[nodiscard]] float pdf(Vec3f direction) const {
    return sampled() ? picture()->pdf(direction) : 0.0f;
  }

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
  struct Patches {
    int across, down;
  };
  [[nodiscard]] Patches patches() const;
  [[nodiscard]] Vec3f direction_at(double across, double down) const;
  [[nodiscard]] static double solid_angle(double top, double bottom);

  std::variant<ConstantSky, GradientSky, Picture> sky_;
  Vec3f up_;  // of a gradient
};

}  // namespace pvol
