#include "report/film_pictures.h"

#include <algorithm>
#include <cmath>

#include "pvol/formats/image.h"
#include "pvol/measure/compare.h"
#include "pvol/measure/trade.h"
#include "report/colour_map.h"
#include "report/html.h"

namespace pvol::cli {
namespace {

/// Luminance of a - b averaged over blocks, which shows a bias that the noise of pixels hides.
std::vector<double> block_differences(const Film& a, const Film& b) {
  constexpr int kBlock = 4;
  const int w = a.crop_width, h = a.crop_height;
  std::vector<double> blocks(a.pixels.size());
  for (int y0 = 0; y0 < h; y0 += kBlock) {
    for (int x0 = 0; x0 < w; x0 += kBlock) {
      const int x1 = std::min(w, x0 + kBlock), y1 = std::min(h, y0 + kBlock);
      double sum = 0;
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x)
          sum += measure::luminance(mean(a.at(x, y)) - mean(b.at(x, y)));
      }
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
          blocks[std::size_t(y) * std::size_t(w) + std::size_t(x)] = sum / ((x1 - x0) * (y1 - y0));
        }
      }
    }
  }
  return blocks;
}

double lookups_of(const PixelSums& p) {
  return p.samples ? double(p.lookups) / double(p.samples) : 0;
}

}  // namespace

double choose_exposure(const Film& film) {
  constexpr double kMiddle = 0.35;  // the mean of a picture that looks well exposed
  const double mean = measure::mean_luminance(film);
  return mean > 0 ? std::clamp(std::log2(kMiddle / mean), -60.0, 60.0) : 0;
}

std::string film_image(const Film& film, double exposure, const std::string& description) {
  return html::image(formats::encode_png(formats::to_picture(film, exposure)), description, true);
}

std::string difference_image(const Film& a, const Film& b, double full,
                             const std::string& description) {
  const formats::Picture p =
      map_colours(block_differences(a, b), a.crop_width, ColourMap::diverging, -full, full);
  return html::image(formats::encode_png(p), description, true);
}

std::string lookup_image(const Film& film, double most, const std::string& description) {
  std::vector<double> values;
  for (const PixelSums& p : film.pixels) values.push_back(std::log1p(lookups_of(p)));
  const formats::Picture p = map_colours(values, film.crop_width, ColourMap::sequential, 0,
                                         std::log1p(std::max(most, 1.0)));
  return html::image(formats::encode_png(p), description, true);
}

double most_lookups(const Film& film) {
  double most = 0;
  for (const PixelSums& p : film.pixels) most = std::max(most, lookups_of(p));
  return most;
}

}  // namespace pvol::cli
