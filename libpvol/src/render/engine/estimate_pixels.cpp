#include "render/engine/estimate_pixels.h"

#include <algorithm>
#include <cmath>

#include "pvol/math/parallel.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/path/film_layers.h"
#include "render/path/gather_light.h"

namespace pvol::detail {
namespace {

constexpr int kSamplesOfPixel = 16;         // of a pixel of the small image
constexpr double kShareOfImage = 1.0 / 64;  // of the samples of the image
constexpr double kLeastPixels = 64, kMostPixels = 4096;

[[nodiscard]] PathSetup make_small(const PathSetup& setup, int pixels) {
  PathSetup whole = setup;
  RenderOptions& o = whole.options;
  o.crop_x = o.crop_y = o.crop_width = o.crop_height = 0;
  o.aovs = {}, o.deep = o.count = false;
  o.first_sample = 0;
  o.seed ^= 0x706978656c73;  // other numbers than those of the image: decisions may not know them
  whole.count = whole.first_collisions = false;
  return whole.in_small(pixels);
}

[[nodiscard]] Film render_small(const PathSetup& small) {
  Film film = make_film(small);
  TileRenderer tiles(small);
  constexpr int kEdge = 16;
  const int columns = (film.width + kEdge - 1) / kEdge, rows = (film.height + kEdge - 1) / kEdge;
  const SampleTargets targets{.all = kSamplesOfPixel};
  parallel_for(0, std::size_t(columns * rows), [&](std::size_t i) {
    const int x = int(i) % columns * kEdge, y = int(i) / columns * kEdge;
    Counts none;
    (void)tiles.render({x, y, std::min(kEdge, film.width - x), std::min(kEdge, film.height - y)},
                       targets, film, none);
  });
  return film;
}

[[nodiscard]] double brightness(const PixelSums& p) {
  return double(absolute_luminance(Rgb(p.sum / double(kSamplesOfPixel))));
}

/// Of each pixel and its neighbours, with the weights 1-2-1 along both axes.
[[nodiscard]] std::vector<double> blurred_brightness(const Film& film) {
  std::vector<double> all;
  for (int y = 0; y < film.height; ++y) {
    for (int x = 0; x < film.width; ++x) {
      double sum = 0, weights = 0;
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, film.height - 1); ++j) {
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, film.width - 1); ++i) {
          const double weight = (i == x ? 2 : 1) * (j == y ? 2 : 1);
          sum += weight * brightness(film.pixels[film.index(i, j)]);
          weights += weight;
        }
      }
      all.push_back(sum / weights);
    }
  }
  return all;
}

/// Brightness below this share of the mean counts as much as that.
constexpr double kDarkest = 0.05;
constexpr double kLeastImportance = 1.0 / 8, kMostImportance = 8;

/// In proportion to the brightness to the power of -3/4 (THEORY.md, T5.5), by roots alone: they are
/// the same on every machine. 1 on average over what is covered by matter.
[[nodiscard]] std::vector<float> importance_of(const Film& film) {
  std::vector<double> all = blurred_brightness(film);
  double mean = 0;
  for (const double b : all) mean += b / double(all.size());
  if (!(mean > 0)) return {};
  double sum = 0, covered = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double b = std::sqrt(all[i] * all[i] + kDarkest * kDarkest * mean * mean) / mean;
    all[i] = 1 / std::sqrt(b * std::sqrt(b));
    sum += film.pixels[i].alpha * all[i], covered += film.pixels[i].alpha;
  }
  std::vector<float> importance;
  if (!(sum > 0)) return importance;
  for (const double v : all) {
    importance.push_back(float(std::clamp(v * covered / sum, kLeastImportance, kMostImportance)));
  }
  return importance;
}

}  // namespace

std::shared_ptr<const PixelImportance> estimate_pixel_importance(const PathSetup& setup) {
  const RenderOptions& o = setup.options;
  const double samples = double(o.width) * o.height * expected_samples(o);
  // How many samples there is time for is not known: they may be few.
  const double most = o.time ? kMostPixels / 4 : kMostPixels;
  const double pixels = std::min(samples * kShareOfImage / kSamplesOfPixel, most);
  if (pixels < kLeastPixels) return nullptr;
  const Film film = render_small(make_small(setup, int(pixels)));
  if (setup.stopped()) return nullptr;
  std::vector<float> importance = importance_of(film);
  if (importance.empty()) return nullptr;
  return std::make_shared<const PixelImportance>(
      PixelImportance{film.width, film.height, std::move(importance)});
}

}  // namespace pvol::detail
