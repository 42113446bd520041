// The settings that pvol-stats trade measures against the default.
#pragma once

#include <string>
#include <vector>

#include "pvol/measure/study.h"
#include "stats/stats_scene.h"

namespace pvol::cli {

/// One setting, and how to change the scene to it. Options whose rows have a `factor` are swept
/// over the values of their rows.
struct Candidate {
  measure::Variant variant;  ///< its option as on the command line of pvol-render
  ChangeScene scene{};
  ChangeCloud cloud{};
};

/// The default: nothing is changed.
[[nodiscard]] Candidate default_candidate();

/// Every setting that changes one factor and can matter to this scene.
[[nodiscard]] std::vector<Candidate> single_candidates(const LoadedScene& loaded);

/// One setting of an option by its key, with a value as on the command line. Throws Error for an
/// unknown key, and for a value out of its limits.
[[nodiscard]] Candidate candidate(const LoadedScene& loaded, const std::string& key,
                                  const std::string& value);

/// Both changes, a's first.
[[nodiscard]] Candidate combine(const Candidate& a, const Candidate& b);

/// Combinations worth measuring (see measure::combinations).
[[nodiscard]] std::vector<Candidate> combinations(
    const std::vector<Candidate>& singles, const std::vector<measure::VariantResult>& results);

}  // namespace pvol::cli
