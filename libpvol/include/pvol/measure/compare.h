// Two pictures of the same view: how far apart they are, and how much of that is not noise.
//
// The films are taken to be independent (other seeds). Their own variances then say what noise
// explains, without any smoothing or reference. With random numbers in common the intervals are too
// wide, and a bias may be missed, but none is invented.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "pvol/render/film.h"

namespace pvol::measure {

struct CompareOptions {
  double confidence = 0.95;  ///< of the intervals, in [0, 1)
  double level = 1e-3;  ///< probability that equal expectations are called different, in (0, 1)
};

/// One channel, or all of them: means are then those of luminance (Rec. 709), and squared errors
/// and variances those of the channels, weighted as in luminance, which is what `noise_of` and all
/// tools call noise. They bound the squares of luminance itself, and those of grey pictures are the
/// same. Means over pixels. What follows from variances is NaN where they are not known.
struct ChannelComparison {
  double mean_a = 0, mean_b = 0;
  double bias = 0;             ///< mean_a - mean_b
  double bias_deviation = 0;   ///< its standard error
  double bias_half_width = 0;  ///< of its confidence interval
  double relative_bias = 0;    ///< bias / mean_b; NaN where that is 0
  double mse = 0, rmse = 0;    ///< of the pixels' differences
  double relative_rmse = 0;    ///< rmse / mean_b; NaN where that is 0
  double explained_mse = 0;    ///< what the variances of both films explain of the MSE
  /// mse - explained_mse: an unbiased estimate of the mean squared difference of the expectations,
  /// and therefore sometimes negative. Of films whose pixels are stratified it is too small by what
  /// their variances are too large (THEORY.md, T5.15).
  double systematic_mse = 0;
  double systematic_half_width = 0;  ///< of its confidence interval; NaN for fewer than 4 blocks
};

/// The difference in luminance that is most significant beside its standard deviation, as estimated
/// from the samples of its pixel in either picture or in both: with few samples that estimate is
/// noisy, as the law of Student takes into account. Pixels without variance are left out.
struct PixelExtreme {
  int x = 0, y = 0;    ///< in the whole image
  double sigmas = 0;   ///< signed
  double p_value = 1;  ///< of the largest of so many pixels (Sidak)
};

/// How many pixels differ by more than k standard deviations, and how many noise leads to expect.
struct PixelTail {
  double sigmas = 0;
  std::uint64_t found = 0;
  double expected = 0;
};

/// The rectangle of the image whose mean differs most significantly.
struct RegionDifference {
  int x = 0, y = 0, width = 0, height = 0;  ///< in the whole image
  int channel = 0;
  double bias = 0, deviation = 0;  ///< of the rectangle's mean, and its standard error
  double p_value = 1;              ///< of this one test
};

/// The verdict: whether the expectations differ, at the level of the options (THEORY.md, T9.1).
/// Two tests share the level. `regions_p_value`: means of the whole picture, of its quarters, of
/// their quarters and so on, so that opposite errors in different places do not cancel; rectangles
/// end at 8 pixels along an edge, and where fewer than 4096 samples would be left: with fewer, the
/// tails of rare bright samples are not yet those of the normal law. `pixels_p_value`: the
/// systematic MSE, which finds errors of a size of pixels. Every channel counts.
///
/// The level holds for films whose samples follow one law (the same estimator), however rare its
/// bright samples are and however many more of them one of the films has, and for others whose
/// samples have moderate tails. A film that lacks the rare bright samples of its law (a strongly
/// forward phase function under a delta sun, without guided paths) is darker than its own variance
/// can tell, and is called different from one of a law without such a tail.
struct BiasVerdict {
  bool detected = false;
  double p_value = 1;  ///< of both together
  double regions_p_value = 1, pixels_p_value = 1;
  std::uint64_t regions = 0;  ///< tests of means, over all channels
  RegionDifference worst;
};

struct FilmComparison {
  CompareOptions options;
  std::uint64_t pixels = 0;
  bool variances_known = false;  ///< every pixel of both films has two samples or more
  std::array<ChannelComparison, 3> channels;
  /// All channels. How far those of one pixel go up and down together is not known: the deviation
  /// of the bias is the largest possible, that of grey pictures.
  ChannelComparison luminance;
  std::optional<PixelExtreme> largest;  ///< none without variances
  std::array<PixelTail, 3> tails{};     ///< beyond 3, 4 and 5 sigma; all 0 without variances
  std::optional<BiasVerdict> verdict;   ///< none without variances
};

/// Compares films of the same rectangle of the same image. Differences as small as the rounding of
/// pixels to float (EXR files) count as none. Throws Error for films that differ in size or place,
/// are empty or hold pixels that are not finite, and for options out of range.
[[nodiscard]] FilmComparison compare(const Film& a, const Film& b,
                                     const CompareOptions& options = {});

/// The standard deviation of a pixel's mean luminance where its channels rise and fall together:
/// that of grey pictures, and never too small.
[[nodiscard]] double luminance_deviation(const PixelSums& pixel);

}  // namespace pvol::measure
