// Comparing pictures in tests: to the last byte, and in expectation.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "pvol/error.h"
#include "pvol/render/film.h"
#include "pvol/volume/shutter.h"
#include "support/statistics.h"

namespace pvol::test {

[[nodiscard]] inline bool same_bytes(const PixelSums& a, const PixelSums& b) {
  const auto bits = [](const PixelSums& p) {
    return std::array<std::uint64_t, 8>{std::bit_cast<std::uint64_t>(p.sum.x),
                                        std::bit_cast<std::uint64_t>(p.sum.y),
                                        std::bit_cast<std::uint64_t>(p.sum.z),
                                        std::bit_cast<std::uint64_t>(p.sum_squares.x),
                                        std::bit_cast<std::uint64_t>(p.sum_squares.y),
                                        std::bit_cast<std::uint64_t>(p.sum_squares.z),
                                        std::bit_cast<std::uint64_t>(p.alpha),
                                        std::bit_cast<std::uint64_t>(p.group)};
  };
  return bits(a) == bits(b) && a.samples == b.samples && a.group_samples == b.group_samples;
}

/// Whether all sums are the same to the last bit; counts may differ.
[[nodiscard]] inline bool same_bytes(const Film& a, const Film& b) {
  if (a.pixels.size() != b.pixels.size()) return false;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (!same_bytes(a.pixels[i], b.pixels[i])) return false;
  }
  return true;
}

/// The film's layer of this name; throws where there is none.
[[nodiscard]] inline const Layer& layer(const Film& film, const std::string& name) {
  for (const Layer& l : film.layers) {
    if (l.name == name) return l;
  }
  throw Error("no layer " + name);
}

/// Mean of a part of a picture, with its variance.
struct Average {
  Vec3d mean, variance;

  friend Average operator+(const Average& a, const Average& b) {
    return {a.mean + b.mean, a.variance + b.variance};
  }
};

[[nodiscard]] inline Average average(const Film& film, int x, int y, int width, int height) {
  Average a;
  const double n = width * height;
  for (int j = y; j < y + height; ++j) {
    for (int i = x; i < x + width; ++i) {
      const PixelSums& p = film.at(i, j);
      a.mean += mean(p) / n;
      a.variance += variance_of_mean(p) / (n * n);
    }
  }
  return a;
}
[[nodiscard]] inline Average average(const Film& film) {
  return average(film, 0, 0, film.crop_width, film.crop_height);
}

/// Of alpha, whose samples lie in [0, 1]: their variance is below alpha (1 - alpha), and just that
/// where paths are analog.
[[nodiscard]] inline Average average_alpha(const Film& film) {
  double sum = 0, n = 0;
  for (const PixelSums& p : film.pixels) sum += p.alpha, n += p.samples;
  return {Vec3d(sum / n), Vec3d(sum / n * (1 - sum / n) / n)};
}

/// Adds the test of equal means, by channel. What a mean lacks of the other by less than `rounding`
/// does not count. Returns the excess of `a` in green, in standard deviations.
inline double compare(const Average& a, const Average& b, const std::string& name,
                      proof::Family& family, double rounding = 0) {
  Vec3d z;
  for (int c = 0; c < 3; ++c) {
    const double difference = a.mean[c] - b.mean[c];
    const double excess = std::max(0.0, std::abs(difference) - rounding);
    const double deviation = std::sqrt(a.variance[c] + b.variance[c]);
    z[c] = excess == 0 ? 0 : std::copysign(excess / deviation, difference);
    family.add(name + ", channel " + std::to_string(c), proof::normal_p_value(z[c]));
  }
  return z.y;
}

/// Adds the test that deviations, each of variance 1, are 0 on average: it finds small errors that
/// all of them share.
inline void add_all_together(const proof::Moments& deviations, const std::string& name,
                             proof::Family& family) {
  family.add(name,
             proof::normal_p_value(deviations.mean() * std::sqrt(double(deviations.count()))));
}
inline void add_all_together(const proof::Moments& deviations, proof::Family& family) {
  add_all_together(deviations, "all together", family);
}

/// Adds tests that two pictures have the same expectation: on average, in each quarter, and in
/// alpha.
inline void compare(const Film& a, const Film& b, const std::string& name, proof::Family& family) {
  compare(average(a), average(b), name, family);
  const int width = a.crop_width / 2, height = a.crop_height / 2;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const int x = quarter % 2 * width, y = quarter / 2 * height;
    compare(average(a, x, y, width, height), average(b, x, y, width, height),
            name + ", quarter " + std::to_string(quarter), family);
  }
  compare(average_alpha(a), average_alpha(b), name + ", alpha", family);
}

/// The samples of all pictures that still(time, seed) makes at times evenly over the shutter, in
/// one film.
template <class Still>
[[nodiscard]] Film over_shutter(const Shutter& shutter, int times, const Still& still) {
  Film sum;
  for (int i = 0; i < times; ++i) {
    const Film part = still(shutter.at((i + 0.5) / times), std::uint64_t(77 + i));
    if (i == 0) {
      sum = part;
      continue;
    }
    for (std::size_t p = 0; p < sum.pixels.size(); ++p) {
      sum.pixels[p].sum += part.pixels[p].sum;
      sum.pixels[p].sum_squares += part.pixels[p].sum_squares;
      sum.pixels[p].alpha += part.pixels[p].alpha;
      sum.pixels[p].samples += part.pixels[p].samples;
    }
  }
  return sum;
}

}  // namespace pvol::test
