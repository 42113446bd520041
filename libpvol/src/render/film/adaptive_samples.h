// What the pixels of a film need, by a pilot of each (THEORY.md, T5.8).
#pragma once

#include <cstddef>
#include <optional>

#include "pvol/render/adaptive_samples.h"
#include "pvol/render/film.h"

namespace pvol::detail {

/// Adaptive samples by a film with the same number of samples, two or more, in every pixel, and
/// with counts, for a noise of pixels (`pixel_noise`); without one, `samples` are kMostSamples.
[[nodiscard]] AdaptiveSamples find_adaptive_samples(const Film& pilot, std::optional<double> noise);

/// What a sample takes in any case, in nanoseconds.
inline constexpr double kSampleCost = 200;

/// Of each pixel of a film with counts: what a sample costs, about, in nanoseconds of a scalar
/// tracer. Kernels in lanes take a fifth of it for all of them.
[[nodiscard]] std::vector<float> sample_costs(const Film& film);

/// Most adaptive samples of a pixel, on average.
inline constexpr double kMostSamples = 1 << 20;

/// The colour, 0 or 1, of pixel `index` of a film: that of the whole image.
[[nodiscard]] inline std::size_t colour_of(const Film& film, std::size_t index) {
  const auto width = std::size_t(film.crop_width);
  return (std::size_t(film.y) + index / width + std::size_t(film.x) + index % width) % 2;
}

/// What the pixels of a crop need, by the needs of a film that holds it.
[[nodiscard]] AdaptiveSamples needs_of_part(const AdaptiveSamples& needs, const Film& film,
                                            const Film& part);

}  // namespace pvol::detail
