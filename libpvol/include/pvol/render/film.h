// The picture with its statistics.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pvol/math/color_space.h"
#include "pvol/math/vec.h"
#include "pvol/render/adaptive_samples.h"
#include "pvol/render/counts.h"
#include "pvol/render/deep.h"
#include "pvol/render/film_sums.h"

namespace pvol {

/// Sums over the samples of one pixel.
struct PixelSums {
  Vec3d sum;          ///< of radiance
  Vec3d sum_squares;  ///< of radiance squared, by channel
  double alpha = 0;   ///< of 1 - transmittance
  std::uint32_t samples = 0;
  std::uint32_t group_samples = 0;  ///< of one of two groups, whose means differ by their noise
  double group = 0;                 ///< of luminance over that group (THEORY.md, T5.15)
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

/// Names of layers of objects (Aov::objects) begin with it.
inline constexpr const char* kObjectLayer = "object.";

/// What depths are where nothing was met, as in other programs.
inline constexpr double kNothingMet = 1e10;

/// The rendered rectangle of an image, rows from the top.
struct Film {
  int width = 0, height = 0;            ///< of the whole image
  int x = 0, y = 0;                     ///< upper left corner of the rectangle in the image
  int crop_width = 0, crop_height = 0;  ///< of the rectangle
  std::vector<PixelSums> pixels;        ///< crop_width * crop_height
  std::vector<PixelCounts> counts{};    ///< of each pixel; empty where counting was off
  std::vector<Layer> layers{};          ///< where they were asked for
  DeepFilm deep{};                      ///< likewise; always of what is before the background
  std::uint32_t first_sample = 0;       ///< number of the first one of each pixel
  /// Of films that were rendered: what rounding the sums of `pixels` and `layers` left.
  FilmRemainders remainders{};
  std::optional<AdaptiveSamples> needs{};  ///< adaptive samples, after the pilot
  ColorSpace color_space = ColorSpace::rec709;

  [[nodiscard]] std::size_t index(int px, int py) const {
    return std::size_t(py) * std::size_t(crop_width) + std::size_t(px);
  }
  [[nodiscard]] const PixelSums& at(int px, int py) const { return pixels[index(px, py)]; }
  /// What a pixel's samples took; 0 where counting was off.
  [[nodiscard]] std::uint64_t count(std::size_t pixel, PixelCounter c) const {
    return counts.empty() ? 0 : counts[pixel][std::size_t(c)];
  }
};

/// A film of the rectangle and the colour space of another, without pixels.
[[nodiscard]] inline Film window_of(const Film& film) {
  Film window;
  window.width = film.width, window.height = film.height;
  window.x = film.x, window.y = film.y;
  window.crop_width = film.crop_width, window.crop_height = film.crop_height;
  window.color_space = film.color_space;
  return window;
}

/// Mean radiance of a pixel; 0 without samples.
[[nodiscard]] inline Vec3d mean(const PixelSums& p) {
  return p.samples ? p.sum / double(p.samples) : Vec3d{};
}

/// A layer's value at a pixel. Without samples that count it is 0, of depths kNothingMet.
[[nodiscard]] Vec3d value(const Layer& layer, const Film& film, std::size_t pixel);

/// Estimate of the variance of that mean, by channel, unbiased where samples are independent and
/// too large where they are stratified; 0 with fewer than two samples.
[[nodiscard]] inline Vec3d variance_of_mean(const PixelSums& p) {
  if (p.samples < 2) return {};
  const double n = p.samples;
  return max((p.sum_squares - p.sum * p.sum / n) / (n * (n - 1)), Vec3d{});
}

/// One number for the variance of that mean: its channels, weighted as in luminance.
[[nodiscard]] inline double noise_of(const PixelSums& p) { return luminance(variance_of_mean(p)); }

/// An estimate of the variance of a pixel's mean luminance, to be averaged over many pixels. With
/// 16 samples or more it follows from their two groups: that knows their stratification, and has
/// one degree of freedom. With fewer, and in films of few pixels, it is `noise_of`.
[[nodiscard]] double luminance_variance(const Film& film, std::size_t pixel);

/// The film's relative noise: the root mean square of its pixels' standard errors over its mean
/// luminance; 0 without light, none where a pixel has fewer than two samples.
[[nodiscard]] std::optional<double> relative_noise(const Film& film);

/// The noise of pixels beside their own brightness, as it is seen once exposure and tone curve have
/// made dark parts visible: the root mean square of their standard errors over
/// sqrt(squared_unit_of_noise). Otherwise as relative_noise.
[[nodiscard]] std::optional<double> pixel_noise(const Film& film);

/// The square of what the noise of a pixel is measured by, in a picture of this mean: its own
/// brightness, and below a hundredth of the mean little less than that.
[[nodiscard]] inline double squared_unit_of_noise(double brightness, double mean_of_picture) {
  constexpr double kDarkest = 0.01;
  const double least = kDarkest * mean_of_picture;
  return brightness * brightness + least * least;
}

/// Gives a film remainders of its size and layers: its sums are exact, and can be added to.
void keep_exact_sums(Film& film);

/// Makes room for so many samples in a pixel; not while others load or store sums.
void make_room(std::uint32_t samples, Film& film);

/// The exact sums of a pixel of a film that has remainders.
void load_sums(const Film& film, std::size_t pixel, ExactSums& sums);

/// Sets what the film has of a pixel, and of its layers there but for least values. There must be
/// room for as many samples as were added.
void store_sums(const ExactSums& sums, std::size_t pixel, Film& film);

/// The part of a film that a rectangle of the image has, which lies in that of the film; without
/// bins of depth and needs.
[[nodiscard]] Film crop_of(const Film& film, int x, int y, int width, int height);

/// Adds the samples of a film that is a part of the same image, lies in this one's, and has the
/// same layers, both with exact sums. Throws Error for others.
void add_part(Film& to, const Film& part);

/// Adds the samples of a film of the same size, with the same layers and bins of depth, and with
/// other random numbers. Throws Error for others. Films with exact sums give the same bits in any
/// order and grouping.
void add_samples(Film& to, const Film& from);

}  // namespace pvol
