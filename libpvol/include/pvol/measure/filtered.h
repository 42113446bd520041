// What a filter of finished pictures (pvol/render/denoise.h) gains and what it falsifies, at one
// number of samples after the other: unlike noise, what it leaves does not fall as 1/sqrt(samples),
// so that no two figures tell all (THEORY.md, T9.3).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pvol/render/denoise.h"
#include "pvol/render/film.h"

namespace pvol::measure {

/// One picture, rendered and filtered.
struct FilterTrial {
  Film film;
  Denoised filtered;
  /// Of CPU time; plain: of the same picture without the layers that only the filter wants.
  double plain_seconds = 0, render_seconds = 0, filter_seconds = 0;
};

/// A mean over trials, with an interval that holds its expectation with a probability of 95 % where
/// trials are normal; infinite for one trial.
struct Interval {
  double value = 0, half_width = 0;
};

/// Trials of one number of samples against a reference. Squared errors are those of the channels,
/// weighted as in luminance; errors are over the mean luminance of the reference.
struct FilterFigures {
  double samples = 0;  ///< a pixel
  int trials = 0;
  double noisy = 0;                       ///< root mean squared error without the filter
  double filtered = 0;                    ///< and with it
  double filtered_square_half_width = 0;  ///< of the interval of its square
  double estimated = 0;  ///< what the filter says of itself, root of the mean square
  Interval bias;         ///< of the picture's mean: filtered less noisy, trial by trial
  /// Root mean square over pixels of the expectation's error, what no number of trials averages
  /// out; 0 where its estimated square is negative, NaN for one trial.
  double systematic = 0;
  double systematic_square_half_width = 0;  ///< of the interval of its square
  double plain_seconds = 0, render_seconds = 0, filter_seconds = 0;  ///< means of one picture

  [[nodiscard]] double seconds() const { return render_seconds + filter_seconds; }
  /// CPU time of an unfiltered picture of the same error over that of the filtered one: above 1 the
  /// filter saves time.
  [[nodiscard]] double gain() const {
    const double more = noisy / filtered;
    return more * more * plain_seconds / seconds();
  }
};

/// Compares at least one trial, of one size and with other seeds, with the reference, whose own
/// noise is taken out. Throws Error for a black reference, and where films differ in size.
[[nodiscard]] FilterFigures judge_filter(const Film& reference,
                                         std::span<const FilterTrial> trials);

/// How to reach an error.
struct FilterAdvice {
  double samples = 0;  ///< a pixel
  double seconds = 0;  ///< of a picture of the size of the trials
};

/// Samples and time that reach this error without the filter: noise falls as 1/sqrt(samples).
[[nodiscard]] FilterAdvice advise_plain(std::span<const FilterFigures> figures, double error);

/// The same with the filter, between the numbers of samples that were measured, by straight lines
/// between the logarithms; of the fewest where those suffice, none where the most do not.
/// `figures` are in the order of their samples, at least one.
[[nodiscard]] std::optional<FilterAdvice> advise_filtered(std::span<const FilterFigures> figures,
                                                          double error);

}  // namespace pvol::measure
