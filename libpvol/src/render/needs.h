// Samples by need: what a pilot of each pixel says about its neighbours (THEORY.md, T5.8).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::detail {

/// Samples that every pixel gets before those that need more get more: forty pixels' together show
/// a variance to some 10 %, where it is not a matter of rare events.
inline constexpr std::uint32_t kPilot = 16;

/// What the pixels of a film need. Each pixel's figures follow from samples of pixels of the other
/// colour of a checkerboard alone, so that its mean stays unbiased.
struct Needs {
  /// Of each pixel: its samples, in proportion; 1 on average over the pixels of either colour.
  std::vector<float> share;
  /// Samples of a pixel of either colour, on average, for a picture of the wanted noise.
  std::array<double, 2> samples{};
};

/// Needs by a film with the same number of samples, two or more, in every pixel, and with counts,
/// for a relative noise (`relative_noise`); without one, `samples` are kMostSamples.
[[nodiscard]] Needs find_needs(const Film& pilot, std::optional<double> noise);

/// What a sample takes in any case, in nanoseconds.
inline constexpr double kSampleCost = 200;

/// Of each pixel of a film with counts: what a sample costs, about, in nanoseconds of a scalar
/// tracer. Kernels in lanes take a fifth of it for all of them.
[[nodiscard]] std::vector<float> sample_costs(const Film& film);

/// Most samples of a pixel, on average, of pictures by need.
inline constexpr double kMostSamples = 1 << 20;

/// The colour, 0 or 1, of pixel `index` of a film.
[[nodiscard]] inline std::size_t colour_of(const Film& film, std::size_t index) {
  const auto width = std::size_t(film.crop_width);
  return (index / width + index % width) % 2;
}

}  // namespace pvol::detail
