// The channels of a film in files. Each has one row: what it means, how its value follows from a
// pixel, and how the pixel's sums follow from the value.
#pragma once

#include <array>
#include <cmath>

#include "pvol/render/film.h"

namespace pvol {

struct FilmChannel {
  const char* name;
  const char* meaning;
  double (*get)(const PixelSums&);
  /// Comes after that of the channels before it in the table, `samples` first.
  void (*put)(PixelSums&, double value);
  bool positive = true;  ///< whether values are never negative
  bool counted = false;  ///< whether it is there only where something was counted
};

/// The sum of what has this mean over the samples.
[[nodiscard]] inline double total(const PixelSums& p, double mean) { return mean * p.samples; }
[[nodiscard]] inline double per_sample(const PixelSums& p, double sum) {
  return p.samples ? sum / p.samples : 0;
}

namespace detail {

template <int kAxis>
[[nodiscard]] constexpr FilmChannel radiance_channel(const char* name) {
  return {name, "mean radiance, linear Rec. 709", [](const PixelSums& p) { return mean(p)[kAxis]; },
          [](PixelSums& p, double v) { p.sum[kAxis] = total(p, v); }, false};
}

template <int kAxis>
[[nodiscard]] constexpr FilmChannel variance_channel(const char* name) {
  return {name, "variance of that mean",
          [](const PixelSums& p) { return variance_of_mean(p)[kAxis]; },
          [](PixelSums& p, double v) {
            const double n = p.samples, sum = p.sum[kAxis];
            if (n > 0) p.sum_squares[kAxis] = v * (n * (n - 1)) + sum * sum / n;
          }};
}

template <PixelCounter kCounter>
[[nodiscard]] constexpr FilmChannel count_channel(const char* name, const char* meaning) {
  constexpr auto k = std::size_t(kCounter);
  return {name,
          meaning,
          [](const PixelSums& p) { return per_sample(p, double(p.counts[k])); },
          [](PixelSums& p, double v) { p.counts[k] = std::uint64_t(std::llround(total(p, v))); },
          true,
          true};
}

}  // namespace detail

inline constexpr std::array kFilmChannels = std::to_array<FilmChannel>({
    {"samples", "camera samples", [](const PixelSums& p) { return double(p.samples); },
     [](PixelSums& p, double v) { p.samples = std::uint32_t(std::lround(v)); }},
    detail::radiance_channel<0>("R"),
    detail::radiance_channel<1>("G"),
    detail::radiance_channel<2>("B"),
    {"A", "1 - transmittance", [](const PixelSums& p) { return per_sample(p, p.alpha); },
     [](PixelSums& p, double v) { p.alpha = total(p, v); }, false},
    detail::variance_channel<0>("variance.R"),
    detail::variance_channel<1>("variance.G"),
    detail::variance_channel<2>("variance.B"),
    detail::count_channel<PixelCounter::lookups>("count.lookups", "look-ups a sample"),
    detail::count_channel<PixelCounter::segments>("count.segments", "segments a sample"),
    detail::count_channel<PixelCounter::collisions>("count.collisions", "collisions a sample"),
});

/// A layer is three channels, "NAME.R" and so on: means, as the radiance's.
inline constexpr std::array kLayerParts = {".R", ".G", ".B"};

}  // namespace pvol
