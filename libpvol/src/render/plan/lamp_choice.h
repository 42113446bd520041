// Whether asking lamps along flights pays.
#pragma once

#include <vector>

#include "pvol/render/plan.h"

namespace pvol::detail {

struct LampChoice {
  std::vector<bool> along_flights{};  ///< for each volume, whether flights ask lamps all along
  const char* reason = nullptr;       ///< null without lamps or volumes
};

/// As the options say, or through thin volumes where a trial says that it pays (THEORY.md, T5.25).
/// Needs the lighting, the kernel and the emission of the plan.
[[nodiscard]] LampChoice choose_lamps(const RenderPlan& plan);

/// Of a choice with a reason.
[[nodiscard]] Decision in_words(const LampChoice& choice);

}  // namespace pvol::detail
