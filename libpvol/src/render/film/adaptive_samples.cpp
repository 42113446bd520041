#include "render/film/adaptive_samples.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "pvol/bounds/octree.h"

namespace pvol::detail {
namespace {

/// Mean over the pixels of either colour.
std::array<double, 2> means(const Film& film, const std::vector<float>& values) {
  std::array<double, 2> sum{}, n{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum[colour_of(film, i)] += double(values[i]);
    ++n[colour_of(film, i)];
  }
  for (std::size_t c = 0; c < 2; ++c) sum[c] = n[c] > 0 ? sum[c] / n[c] : 0;
  return sum;
}

enum class Near { other_colour, same_colour, same_colour_with_itself };

/// Mean over the pixels of a colour up to so many columns and rows from pixel (x, y); 0 where there
/// are none.
double mean_around(const Film& film, const std::vector<float>& values, int x, int y, Near which,
                   int reach) {
  double sum = 0, n = 0;
  for (int j = std::max(0, y - reach); j <= std::min(film.crop_height - 1, y + reach); ++j) {
    for (int i = std::max(0, x - reach); i <= std::min(film.crop_width - 1, x + reach); ++i) {
      const bool other = (i - x + j - y) % 2 != 0;
      if (other != (which == Near::other_colour)) continue;
      if (i == x && j == y && which != Near::same_colour_with_itself) continue;
      sum += double(values[film.index(i, j)]);
      ++n;
    }
  }
  return n > 0 ? sum / n : 0;
}

/// Of each pixel: variance of the luminance of one sample over the square of the brightness of some
/// dozen pixels of its colour there, as `pixel_noise` has it. A pixel's own brightness would be too
/// large where a rare bright sample was found, and too small where none was.
std::vector<float> relative_variances(const Film& film) {
  constexpr int kReach = 2;
  std::vector<float> brightness, all;
  for (const PixelSums& p : film.pixels) brightness.push_back(luminance(Rgb(mean(p))));
  const std::array<double, 2> everywhere = means(film, brightness);
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      const std::size_t i = film.index(x, y);
      const double near =
          mean_around(film, brightness, x, y, Near::same_colour_with_itself, kReach);
      const double unit = squared_unit_of_noise(near, everywhere[colour_of(film, i)]);
      const double variance = luminance_variance(film, i) * film.pixels[i].samples;
      all.push_back(unit > 0 ? float(variance / unit) : 0.0f);
    }
  }
  return all;
}

/// Samples of each pixel, in proportion to the square root of variance over cost around it: that
/// makes the mean variance least for the work. Mean 1 in either colour.
std::vector<float> shares(const Film& film, const std::vector<float>& variance,
                          const std::vector<float>& cost, Near which) {
  constexpr double kFar = 0.02;  // of the variance everywhere, for what a neighbourhood missed
  constexpr int kReach = 4;      // some forty pixels
  std::array<double, 2> everywhere = means(film, variance);
  if (which == Near::other_colour) std::swap(everywhere[0], everywhere[1]);
  std::vector<float> all(variance.size());
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      const std::size_t i = film.index(x, y);
      const double near = mean_around(film, variance, x, y, which, kReach);
      const double work = std::max(mean_around(film, cost, x, y, which, kReach), double(FLT_MIN));
      all[i] = float(std::sqrt((near + kFar * everywhere[colour_of(film, i)]) / work));
    }
  }
  const std::array<double, 2> mean = means(film, all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double m = mean[colour_of(film, i)];
    all[i] = m > 0 ? float(double(all[i]) / m) : 1.0f;
  }
  return all;
}

/// Mean variance of the pixels of a colour, if each has its share of so many samples, and no less
/// than the pilot's.
double expected_variance(const Film& film, std::size_t colour, const std::vector<float>& variance,
                         const std::vector<float>& share, double samples) {
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < variance.size(); ++i) {
    if (colour_of(film, i) != colour) continue;
    sum += double(variance[i]) / std::max(double(kPilot), samples * double(share[i]));
    ++n;
  }
  return n > 0 ? sum / n : 0;
}

/// Samples a pixel for a noise of pixels, by one colour's pixels alone.
double samples_for(double noise, const Film& film, std::size_t colour,
                   const std::vector<float>& variance, const std::vector<float>& share) {
  const auto suffice = [&](double samples) {
    return expected_variance(film, colour, variance, share, samples) <= noise * noise;
  };
  if (suffice(0)) return 0;
  // Where most pixels are calm, the shares of the others are large, and fewer samples than the
  // pilot has are more for them.
  double lo = suffice(kPilot) ? 1e-3 : kPilot, hi = kMostSamples;
  while (hi > 1.001 * lo) {
    const double middle = std::sqrt(lo * hi);
    (suffice(middle) ? hi : lo) = middle;
  }
  return hi;
}

}  // namespace

std::vector<float> sample_costs(const Film& film) {
  constexpr double kCollision = 150;
  const WalkCosts c;
  std::vector<float> all;
  all.reserve(film.pixels.size());
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const auto count = [&](PixelCounter of) { return double(film.count(i, of)); };
    const double work = kCollision * count(PixelCounter::collisions) +
                        c.segment * count(PixelCounter::segments) +
                        (c.lookup + c.tentative) * count(PixelCounter::lookups);
    all.push_back(float(kSampleCost + work / film.pixels[i].samples));
  }
  return all;
}

AdaptiveSamples find_adaptive_samples(const Film& pilot, std::optional<double> noise) {
  const std::vector<float> variance = relative_variances(pilot);
  const std::vector<float> cost = sample_costs(pilot);
  AdaptiveSamples n{shares(pilot, variance, cost, Near::other_colour),
                    {kMostSamples, kMostSamples}};
  if (!noise) return n;
  const std::vector<float> own = shares(pilot, variance, cost, Near::same_colour);
  for (std::size_t c = 0; c < 2; ++c) {
    n.samples[c] = samples_for(*noise, pilot, 1 - c, variance, own);
  }
  return n;
}

AdaptiveSamples needs_of_part(const AdaptiveSamples& needs, const Film& film, const Film& part) {
  AdaptiveSamples n{{}, needs.samples};
  n.share.reserve(part.pixels.size());
  for (int y = 0; y < part.crop_height; ++y) {
    const std::size_t row = film.index(part.x - film.x, part.y - film.y + y);
    const auto from = needs.share.begin() + std::ptrdiff_t(row);
    n.share.insert(n.share.end(), from, from + part.crop_width);
  }
  return n;
}

}  // namespace pvol::detail
