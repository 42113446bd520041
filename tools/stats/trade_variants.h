// The settings that pvol-stats trade measures against the default.
#pragma once

#include <string>
#include <vector>

#include "stats/stats_scene.h"

namespace pvol::cli {

/// One setting. A new option of the renderer becomes one entry of `single_variants`.
struct Variant {
  std::string factor;   ///< what it changes: only one of a factor goes into a combination
  std::string option;   ///< as on the command line of pvol-render; its name in the report
  bool biased = false;  ///< by design: the picture converges to another one than the default's
  ChangeScene scene{};
  ChangeCloud cloud{};
};

/// The default: nothing is changed.
[[nodiscard]] Variant default_variant();

/// Every setting that changes one factor and can matter to this scene.
[[nodiscard]] std::vector<Variant> single_variants(const LoadedScene& loaded);

/// Both changes, a's first.
[[nodiscard]] Variant combine(const Variant& a, const Variant& b);

/// What the search for combinations knows of a setting.
struct VariantResult {
  bool measured = false;
  double gain = 1;         ///< time x variance over the default's; below 1 is better
  double proven_gain = 1;  ///< the upper end of its interval
  double offset = 0;       ///< root of its mean squared systematic error over the mean luminance
};

/// Combinations worth measuring, of the settings with these results: the best unbiased settings of
/// the three factors that gain most, in pairs and all together; and the fastest biased settings of
/// two factors whose systematic error is below 2 %, each together with the best of the unbiased.
/// Only settings that are proven to gain, but for noise, take part.
[[nodiscard]] std::vector<Variant> combinations(const std::vector<Variant>& singles,
                                                const std::vector<VariantResult>& results);

}  // namespace pvol::cli
