// The picture with its statistics.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pvol/math/vec.h"
#include "pvol/render/counts.h"
#include "pvol/render/deep.h"

namespace pvol {

/// Sums over the samples of one pixel, in sample order and in double.
struct PixelSums {
  Vec3d sum;          ///< of radiance
  Vec3d sum_squares;  ///< of radiance squared, by channel
  double alpha = 0;   ///< of 1 - transmittance
  std::uint32_t samples = 0;
  /// Totals by PixelCounter; 0 where counting was off.
  std::array<std::uint64_t, kPixelCounts.size()> counts{};

  [[nodiscard]] std::uint64_t count(PixelCounter c) const { return counts[std::size_t(c)]; }
};

/// What a film keeps of each pixel beside its own sums, such as the light of one source.
struct Layer {
  std::string name;                ///< as the first part of its channels' names: "sun_1"
  std::vector<Vec3d> sums;         ///< over the samples of each pixel; of one component in x
  std::string components = "RGB";  ///< or "XYZ", or one letter: the last part of those names
  /// Of each pixel what its sum is divided by, where that is not its samples.
  std::vector<double> weights{};
  bool least = false;  ///< whether `sums` has the least values instead
};

/// What depths are where nothing was met, as in other programs.
inline constexpr double kNothingMet = 1e10;

/// The rendered rectangle of an image, rows from the top.
struct Film {
  int width = 0, height = 0;            ///< of the whole image
  int x = 0, y = 0;                     ///< upper left corner of the rectangle in the image
  int crop_width = 0, crop_height = 0;  ///< of the rectangle
  std::vector<PixelSums> pixels;        ///< crop_width * crop_height
  std::vector<Layer> layers{};          ///< where they were asked for
  DeepFilm deep{};                      ///< likewise; always of what is before the background

  [[nodiscard]] std::size_t index(int px, int py) const {
    return std::size_t(py) * std::size_t(crop_width) + std::size_t(px);
  }
  [[nodiscard]] const PixelSums& at(int px, int py) const { return pixels[index(px, py)]; }
};

/// Mean radiance of a pixel; 0 without samples.
[[nodiscard]] inline Vec3d mean(const PixelSums& p) {
  return p.samples ? p.sum / double(p.samples) : Vec3d{};
}

/// A layer's value at a pixel. Without samples that count it is 0, of depths kNothingMet.
[[nodiscard]] Vec3d value(const Layer& layer, const Film& film, std::size_t pixel);

/// Unbiased estimate of the variance of that mean, by channel; 0 with fewer than two samples.
[[nodiscard]] inline Vec3d variance_of_mean(const PixelSums& p) {
  if (p.samples < 2) return {};
  const double n = p.samples;
  return max((p.sum_squares - p.sum * p.sum / n) / (n * (n - 1)), Vec3d{});
}

/// One number for the variance of that mean: its channels, weighted as in luminance.
[[nodiscard]] inline double noise_of(const PixelSums& p) {
  const Vec3d v = variance_of_mean(p);
  return 0.2126 * v.x + 0.7152 * v.y + 0.0722 * v.z;
}

/// The film's relative noise: the root mean square of its pixels' standard errors over its mean
/// luminance; 0 without light, none where a pixel has fewer than two samples.
[[nodiscard]] std::optional<double> relative_noise(const Film& film);

/// Adds the samples of a film of the same size, with the same layers and bins of depth, rendered
/// with another seed. Throws Error for others.
void add_samples(Film& to, const Film& from);

}  // namespace pvol
