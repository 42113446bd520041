// Whether asking lamps along flights pays.
#pragma once

#include <span>
#include <vector>

#include "pvol/render/lighting.h"
#include "pvol/render/plan.h"

namespace pvol::detail {

/// For each volume, whether flights through it ask lamps all along: as the options say, or where it
/// is thin and lamps bring much of the light (THEORY.md, T5.25).
[[nodiscard]] std::vector<bool> choose_line_lamps(std::span<const Volume> volumes,
                                                  const Scene& scene, const Lighting& lighting);

/// That in words, of scenes with lamps and volumes.
[[nodiscard]] std::optional<Decision> decide_line_lamps(const RenderPlan& p, LineLamps wanted);

}  // namespace pvol::detail
