// A picture of a sky made ready for rays and for sampling.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pvol/math/rng.h"
#include "pvol/render/light_sample.h"
#include "pvol/render/sky.h"

namespace pvol {

/// How radiance goes between the pixels of a sky's picture.
enum class SkyPixels {
  even,    ///< constant in each
  smooth,  ///< theirs at their middles and bilinear between, but not across the horizon, which is
           ///< the edge between two rows: heights must be even numbers
};

/// Pixels are chosen in proportion to the luminance at their middles times their solid angle;
/// within one, directions are even. Radiance is what it is at the direction, so that estimates by
/// samples are right for smooth pixels, too: with those a pixel is as likely as the brightest that
/// its radiance is mixed of, so that none with light is left out.
class SkyPicture {
 public:
  /// The picture has at least one pixel.
  SkyPicture(ImageSky image, SkyPixels pixels);

  [[nodiscard]] Rgb radiance(Vec3f direction) const;
  /// False for a black picture, which must not be sampled.
  [[nodiscard]] bool sampled() const { return !bins_.empty(); }
  [[nodiscard]] LightSample sample(Rng& rng) const;
  /// Luminance averaged over all directions.
  [[nodiscard]] float mean_luminance() const { return mean_luminance_; }
  /// The largest of any direction.
  [[nodiscard]] float largest_luminance() const { return largest_luminance_; }
  /// Density per steradian of `sample`, where `sampled()`.
  [[nodiscard]] float pdf(Vec3f direction) const { return pixel_pdf(pixel_at(direction)); }

  [[nodiscard]] int width() const { return image_.width; }
  [[nodiscard]] int height() const { return image_.height; }
  /// One of as many as there are pixels, equally likely: its own pixel where a random number of 32
  /// bits is not above `own`, else another (Walker 1977).
  struct Bin {
    std::uint32_t own, other;
  };
  /// The upper edge of a row of pixels and how far its lower edge is from that, as 1 - |cos| of the
  /// angle to the nearer pole: floats hold that exactly enough where |cos| is nearly 1.
  struct Row {
    float from, extent;
  };
  /// What samples are made of, for those who make many at once.
  struct Tables {
    int width, height;
    int upper_rows;           ///< whose nearer pole is the upper one
    float rotation;           ///< in turns
    Vec3f x, y, z;            ///< rows of the map from the picture's axes to the world
    const Rgb* pixels;        ///< radiances
    const float* weights;     ///< by which smooth pixels are chosen; null: by their luminance
    float pdf_per_luminance;  ///< density per steradian of a pixel that is chosen by luminance 1
    std::span<const Bin> bins;
    const Row* rows;
  };
  [[nodiscard]] Tables tables() const;

  /// Of a place in the picture, over its width from the left and its height from above.
  [[nodiscard]] Vec3f direction_at(double across, double down) const;

 private:
  struct Pixel {
    int x, y;
  };
  /// In pixels from the left and upper edges.
  struct Place {
    float x, y;
  };
  [[nodiscard]] static std::vector<Bin> make_bins(std::vector<double> shares);
  [[nodiscard]] Place place_of(Vec3f direction) const;
  [[nodiscard]] Pixel pixel_at(Vec3f direction) const;
  [[nodiscard]] int upper_rows() const { return (image_.height + 1) / 2; }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(image_.width) + std::size_t(x);
  }
  [[nodiscard]] Rgb at(int x, int y) const { return pixels_[index(x, y)]; }
  [[nodiscard]] Rgb mixed(Place p) const;
  [[nodiscard]] float weight(int x, int y) const;
  [[nodiscard]] float pixel_pdf(Pixel p) const;

  ImageSky image_;               // pixels are radiances: times the scale
  const Rgb* pixels_ = nullptr;  // those, which copies share: one step nearer for every look-up
  bool smooth_;
  float rotation_ = 0;                          // in turns
  bool turned_ = false;                         // whether the picture's upper edge is not +y
  Vec3f x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1};  // its axes in the world
  std::vector<float> weights_;                  // of smooth pixels, by which they are chosen
  std::vector<Bin> bins_;
  std::vector<Row> rows_;
  float mean_luminance_ = 0, largest_luminance_ = 0;
  double pdf_per_luminance_ = 0;
};

}  // namespace pvol
