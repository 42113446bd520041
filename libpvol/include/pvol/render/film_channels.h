// The channels that follow from a pixel's own sums, as files name them. Each has one row: how its
// value follows from a pixel, and how the pixel's sums follow from the value. What they mean stands
// beside their AOV (aov.h). A film's layers (film.h) are channels besides.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "pvol/render/aov.h"
#include "pvol/render/film.h"

namespace pvol {

struct FilmChannel {
  const char* name;
  std::optional<Aov> aov;  ///< what has to be asked for; nothing for colour and alpha
  double (*get)(const Film&, std::size_t pixel);
  /// Comes after that of the channels before it in the table, `samples` first.
  void (*put)(Film&, std::size_t pixel, double value);
  bool positive = true;            ///< whether values are never negative
  bool number = false;             ///< of samples, or of something counted
  const char* old_name = nullptr;  ///< in files of versions before there were AOVs
};

/// The sum of what has this mean over the samples.
[[nodiscard]] inline double total(const PixelSums& p, double mean) { return mean * p.samples; }
[[nodiscard]] inline double per_sample(const PixelSums& p, double sum) {
  return p.samples ? sum / p.samples : 0;
}

namespace detail {

template <int kAxis>
[[nodiscard]] constexpr FilmChannel radiance_channel(const char* name) {
  return {.name = name,
          .aov = {},
          .get = [](const Film& f, std::size_t i) { return mean(f.pixels[i])[kAxis]; },
          .put = [](Film& f, std::size_t i,
                    double v) { f.pixels[i].sum[kAxis] = total(f.pixels[i], v); },
          .positive = false};
}

template <int kAxis>
[[nodiscard]] constexpr FilmChannel variance_channel(const char* name) {
  return {.name = name,
          .aov = Aov::variance,
          .get = [](const Film& f, std::size_t i) { return variance_of_mean(f.pixels[i])[kAxis]; },
          .put =
              [](Film& f, std::size_t i, double v) {
                PixelSums& p = f.pixels[i];
                const double n = p.samples, sum = p.sum[kAxis];
                if (n > 0) p.sum_squares[kAxis] = v * (n * (n - 1)) + sum * sum / n;
              }};
}

template <PixelCounter kCounter>
[[nodiscard]] constexpr FilmChannel count_channel(const char* name, Aov aov, const char* old_name) {
  return {
      .name = name,
      .aov = aov,
      .get = [](const Film& f,
                std::size_t i) { return per_sample(f.pixels[i], double(f.count(i, kCounter))); },
      .put =
          [](Film& f, std::size_t i, double v) {
            f.counts.resize(f.pixels.size());
            f.counts[i][std::size_t(kCounter)] = std::uint64_t(std::llround(total(f.pixels[i], v)));
          },
      .number = true,
      .old_name = old_name};
}

}  // namespace detail

inline constexpr std::array kFilmChannels = std::to_array<FilmChannel>({
    {.name = "samples.Y",
     .aov = Aov::samples,
     .get = [](const Film& f, std::size_t i) { return double(f.pixels[i].samples); },
     .put = [](Film& f, std::size_t i,
               double v) { f.pixels[i].samples = std::uint32_t(std::lround(v)); },
     .number = true,
     .old_name = "samples"},
    detail::radiance_channel<0>("R"),
    detail::radiance_channel<1>("G"),
    detail::radiance_channel<2>("B"),
    // 1 - transmittance; files may have 1 for it where a background is seen.
    {.name = "A",
     .aov = {},
     .get = [](const Film& f, std::size_t i) { return per_sample(f.pixels[i], f.pixels[i].alpha); },
     .put = [](Film& f, std::size_t i, double v) { f.pixels[i].alpha = total(f.pixels[i], v); },
     .positive = false},
    {.name = "transmittance.Y",
     .aov = Aov::transmittance,
     .get =
         [](const Film& f, std::size_t i) {
           const PixelSums& p = f.pixels[i];
           return per_sample(p, p.samples - p.alpha);
         },
     .put = [](Film& f, std::size_t i,
               double v) { f.pixels[i].alpha = f.pixels[i].samples - total(f.pixels[i], v); },
     .positive = false},
    detail::variance_channel<0>("variance.R"),
    detail::variance_channel<1>("variance.G"),
    detail::variance_channel<2>("variance.B"),
    detail::count_channel<PixelCounter::lookups>("lookups.Y", Aov::lookups, "count.lookups"),
    detail::count_channel<PixelCounter::bounds_tests>("bounds_tests.Y", Aov::bounds_tests, ""),
    detail::count_channel<PixelCounter::segments>("segments.Y", Aov::segments, "count.segments"),
    detail::count_channel<PixelCounter::collisions>("collisions.Y", Aov::collisions,
                                                    "count.collisions"),
});

}  // namespace pvol
