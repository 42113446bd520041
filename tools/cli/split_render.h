// pvol-render --split: a picture as work for many machines. Without the farm (PVOL_WITH_FARM=OFF)
// without_farm.cpp refuses it.
#pragma once

#include <string>

#include "cli/render_options.h"
#include "pvol/render/plan.h"

namespace pvol::cli {

/// Throws UsageError for options that do not go with --split, and for those that only go with it.
void check_split(const RenderOptionsGiven& o);

struct SplitText {
  std::string commands;  ///< of the parts and merges, as --for asks
  std::string summary;   ///< for people, one line
};

/// Cuts all frames as the plan's picture. Throws UsageError for more parts than samples, and what
/// map_cost throws.
[[nodiscard]] SplitText split_text(const RenderOptionsGiven& o, const RenderPlan& plan);

}  // namespace pvol::cli
