#include "pvol/measure/pixel_maps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/measure/compare.h"
#include "pvol/measure/trade.h"

namespace pvol::measure {
namespace {

constexpr double kMostStops = 60;

double difference(const PixelSums& a, const PixelSums& b) { return luminance(mean(a) - mean(b)); }

/// In a film's pixels, for each of something that they have so many of; 0 where that is none.
template <class F>
std::vector<double> lookups_for_each(const Film& film, const F& number) {
  std::vector<double> values;
  values.reserve(film.pixels.size());
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const double n = double(number(i));
    values.push_back(n > 0 ? double(film.count(i, PixelCounter::lookups)) / n : 0);
  }
  return values;
}

}  // namespace

Differences differences(const Film& a, const Film& b) {
  Differences d;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double value = difference(a.pixels[i], b.pixels[i]);
    const double deviation =
        std::hypot(luminance_deviation(a.pixels[i]), luminance_deviation(b.pixels[i]));
    d.values.push_back(value);
    d.sigmas.push_back(deviation > 0 ? value / deviation : 0);
  }
  return d;
}

std::vector<double> block_differences(const Film& a, const Film& b, int edge) {
  const int w = a.crop_width, h = a.crop_height;
  std::vector<double> blocks(a.pixels.size());
  for (int y0 = 0; y0 < h; y0 += edge) {
    for (int x0 = 0; x0 < w; x0 += edge) {
      const int x1 = std::min(w, x0 + edge), y1 = std::min(h, y0 + edge);
      double sum = 0;
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) sum += difference(a.at(x, y), b.at(x, y));
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

Film difference_film(const Film& a, const Film& b) {
  Film d = a;
  d.layers.clear(), d.counts.clear();
  d.remainders = {};
  for (std::size_t i = 0; i < d.pixels.size(); ++i) {
    const PixelSums &pa = a.pixels[i], &pb = b.pixels[i];
    PixelSums& p = d.pixels[i];
    p = {};
    p.samples = pa.samples + pb.samples;
    const double n = p.samples;
    p.sum = (mean(pa) - mean(pb)) * n;
    p.sum_squares = (variance_of_mean(pa) + variance_of_mean(pb)) * (n * (n - 1)) +
                    p.sum * p.sum / std::max(n, 1.0);
  }
  return d;
}

std::vector<double> lookups_per_sample(const Film& film) {
  return lookups_for_each(film, [&](std::size_t i) { return film.pixels[i].samples; });
}

std::vector<double> lookups_per_collision(const Film& film) {
  return lookups_for_each(film,
                          [&](std::size_t i) { return film.count(i, PixelCounter::collisions); });
}

double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return 0;
  const auto at = std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[std::size_t(at)];
}

double range_of(std::vector<double> values, double share) {
  for (double& v : values) v = std::abs(v);
  const double most = quantile(values, share), all = quantile(std::move(values), 1);
  return most > 0 ? most : all > 0 ? all : 1;
}

double exposure_for_mean(const Film& film) {
  constexpr double kMiddle = 0.35;  // the mean of a picture that looks well exposed
  const double mean = mean_luminance(film);
  return mean > 0 ? std::clamp(std::log2(kMiddle / mean), -kMostStops, kMostStops) : 0;
}

double exposure_below_white(const Film& a, const Film& b, double share) {
  std::vector<double> bright;
  for (const Film* f : {&a, &b}) {
    for (const PixelSums& p : f->pixels) bright.push_back(luminance(mean(p)));
  }
  const double white = quantile(std::move(bright), share);
  return white > 0 ? std::clamp(-std::log2(white), -kMostStops, kMostStops) : 0;
}

double SigmaHistogram::expected(double x) const {
  return std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi) * width;
}

SigmaHistogram sigma_histogram(const std::vector<double>& sigmas) {
  SigmaHistogram h;
  const auto bins = std::size_t(2 * h.end / h.width);
  h.shares.resize(bins);
  for (const double s : sigmas) {
    if (s == 0) continue;  // pixels without variance say nothing
    h.shares[std::size_t(std::clamp((s + h.end) / h.width, 0.0, double(bins - 1)))] += 1;
    ++h.pixels;
  }
  for (double& share : h.shares) share /= std::max(h.pixels, 1.0);
  return h;
}

}  // namespace pvol::measure
