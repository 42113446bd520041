// Judging settings of a render against each other: ratios of what was measured in turn, the Pareto
// front, and which setting reaches an error or a time (THEORY.md, T9.2).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::measure {

/// A median with an interval that holds the true one with probability `coverage`, whatever the
/// distribution.
struct Estimate {
  double value = 0, low = 0, high = 0;
  double coverage = 0;  ///< in [0, 1); 0 for fewer than two values, whose interval is the value
};

/// The median of independent values of one distribution, between the narrowest pair of them that
/// holds it with probability `coverage`; with too few values for that, between the outermost two,
/// and the estimate's own coverage says what they reach: 1 - 2^(1-n). Takes at least one value.
[[nodiscard]] Estimate estimate_median(std::vector<double> values, double coverage = 0.95);

/// Median of a[i] / b[i]: both measured in the same round i, so that what slows the machine down
/// for a while slows both.
[[nodiscard]] Estimate estimate_ratio(std::span<const double> a, std::span<const double> b,
                                      double coverage = 0.95);

/// How many times less: the ratio upside down. None of the three numbers is 0.
[[nodiscard]] Estimate inverse(const Estimate& ratio);

/// The median alone; 0 for no values.
[[nodiscard]] double median(const std::vector<double>& values);

/// Level of each of `comparisons` tests with which all of them together raise a false alarm with
/// probability `family` at most, if they are independent or positively dependent (Sidak 1967).
[[nodiscard]] double sidak_level(double family, std::size_t comparisons);

/// Luminance (BT.709) averaged over the film's pixels.
[[nodiscard]] double mean_luminance(const Film& film);

/// Variance of one sample (`luminance_variance`, times samples), averaged over the film's pixels; 0
/// for fewer than two samples a pixel.
[[nodiscard]] double sample_variance(const Film& film);

/// What a setting costs in three ways, each better when less.
using Costs = std::array<double, 3>;

/// The settings that no other one beats: none is at most as dear in every way and less in one.
/// Ascending; equal ones are all on the front. Quadratic in the number of settings.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const Costs> settings);

/// A setting as measured.
struct Setting {
  double seconds = 0;   ///< CPU time of a sample
  double set_up = 0;    ///< CPU seconds before the first sample
  double variance = 0;  ///< of a sample, averaged over the pixels
  double offset = 0;    ///< mean over the pixels of the squared systematic error; 0 where unbiased
  /// Factor by which time x variance may be larger than measured, for settings that have to prove
  /// that they beat the first one; at least 1.
  double doubt = 1;
};

/// How to render with the setting chosen.
struct Advice {
  std::size_t setting = 0;
  double samples = 0;  ///< a pixel
  double seconds = 0;  ///< CPU time of the picture
  double error = 0;    ///< root of the mean squared error, in the unit of the variance
};

/// What rendering a picture of this many pixels takes and errs with so many samples a pixel. The
/// number of the setting is 0.
[[nodiscard]] Advice forecast(const Setting& setting, double pixels, double samples);

/// The setting that renders a picture of this many pixels with at most this error in least time, if
/// any can: one whose offset alone exceeds the error cannot.
[[nodiscard]] std::optional<Advice> advise_for_error(std::span<const Setting> settings,
                                                     double pixels, double error);

/// The setting with the least error after this much CPU time, if any takes one sample a pixel in
/// it.
[[nodiscard]] std::optional<Advice> advise_for_time(std::span<const Setting> settings,
                                                    double pixels, double seconds);

}  // namespace pvol::measure
