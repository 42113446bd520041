// A study: settings of a render measured in turn, judged against the first of them and against one
// reference. Ratios of costs, tests for bias, the Pareto front, and which setting reaches a goal
// (THEORY.md, T9.2). A study of one factor, such as the depth of the octree, and one of everything
// that a user can set are the same study of other settings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pvol/measure/compare.h"
#include "pvol/measure/sweep.h"
#include "pvol/measure/trade.h"

namespace pvol::measure {

/// Probability that a study calls any setting biased that is not.
inline constexpr double kFalseAlarms = 0.01;

/// What a setting changes.
struct Variant {
  std::string factor;   ///< only one of a factor goes into a combination
  std::string option;   ///< how to ask for it, and its name; empty for the default
  bool biased = false;  ///< by design: the picture converges to another one than the default's
};

/// Work counted, a sample, of camera paths and shadow rays together.
struct Work {
  double lookups = 0, bounds_tests = 0, segments = 0;
};

/// One setting with its figures relative to the first one. What follows `measured` is there where
/// the setting was measured.
struct Row {
  Variant variant;
  Measured measured;
  Estimate time, variance, cost;         ///< ratios to the first's; cost: time x variance
  std::optional<Estimate> instructions;  ///< a sample, of the first's
  Work work;
  double sample_variance = 0;     ///< of one sample, averaged over the pixels
  FilmComparison bias;            ///< against the reference
  double rmse_of_one_sample = 0;  ///< a pixel, against the reference, over its mean luminance
  std::uint64_t file_bytes = 0;   ///< of files that hold the clouds so; counts for the front
  bool on_front = false;
  Setting setting;  ///< for advice

  [[nodiscard]] bool good() const { return measured.left_out.empty(); }
  [[nodiscard]] bool detected() const { return bias.verdict && bias.verdict->detected; }
  /// Root of the mean squared systematic error over the reference's mean luminance, as far as its
  /// interval allows it to be; 0 for settings without bias.
  [[nodiscard]] double offset() const;
  /// Time x variance for the front: a hair above the default's where noise does not tell the two
  /// apart, so that the default stands for all that are like it.
  [[nodiscard]] double proven_cost() const;
  /// Look-ups of a sample x its variance: the work of a picture of given noise, counted.
  [[nodiscard]] double lookup_cost() const { return work.lookups * sample_variance; }
  /// In memory and in files.
  [[nodiscard]] double bytes() const;
};

/// What a picture is to reach: an error or a time.
struct Goal {
  std::optional<double> error{};    ///< root mean squared, over the mean luminance
  std::optional<double> seconds{};  ///< of CPU time
  std::optional<Advice> advice{};   ///< its setting is the number of a row; none: out of reach
};

struct Study {
  Film reference;
  double reference_mean = 0;            ///< luminance
  std::uint32_t reference_samples = 0;  ///< a pixel
  double picture_pixels = 0;            ///< of the picture that the goals are about
  double level = 0;                     ///< of each test for bias
  std::vector<Row> rows;                ///< the first is what the others are compared with
  std::vector<Goal> goals;
};

/// Throws Error for a black film: errors are relative to its mean.
void set_reference(Study& study, Film reference);

/// Compares settings with the first of them, which was measured in the same rounds.
[[nodiscard]] std::vector<Row> make_rows(const std::vector<Variant>& variants,
                                         std::vector<Measured> measured);

/// Tests every row against the reference, all together at the level of `kFalseAlarms`.
void test_biases(Study& study);

/// The same, and finds the front and a setting for each goal.
void judge(Study& study);

/// What the intervals of a study hold.
struct Coverage {
  int rounds = 0;          ///< of the setting with fewest
  double probability = 1;  ///< that the interval of a time holds the median, at least
};
[[nodiscard]] Coverage coverage(const Study& study);

// --- combinations -------------------------------------------------------------------------------

/// What the search for combinations knows of a setting.
struct VariantResult {
  bool measured = false;
  double gain = 1;         ///< time x variance over the default's; below 1 is better
  double proven_gain = 1;  ///< the upper end of its interval
  double offset = 0;       ///< root of its mean squared systematic error over the mean luminance
};
[[nodiscard]] VariantResult result_of(const Row& row);

/// Combinations worth measuring, of the settings with these results: the best unbiased settings of
/// the three factors that gain most, in pairs and all together; and the fastest biased settings of
/// two factors whose systematic error is below 2 %, each together with the best of the unbiased.
/// Only settings that are proven to gain, but for noise, take part. Each is a list of settings in
/// the order in which they are to be applied.
[[nodiscard]] std::vector<std::vector<std::size_t>> combinations(
    const std::vector<Variant>& singles, const std::vector<VariantResult>& results);

// --- building -----------------------------------------------------------------------------------

/// CPU seconds of building what a setting needs, by round.
struct BuildTimes {
  std::vector<double> bounds;  ///< extremes of all voxels
  std::vector<double> tree;    ///< bricks and octree
};

/// Relative to the building of another setting in the same rounds.
struct BuildRatios {
  Estimate all, tree;
};
[[nodiscard]] BuildRatios compare_building(const BuildTimes& of, const BuildTimes& base);

}  // namespace pvol::measure
