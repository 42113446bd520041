// What asking lamps along flights would bring, by trial.
#pragma once

#include "pvol/render/plan.h"

namespace pvol::detail {

/// Samples of a picture with lamps asked along flights, and of the same with lamps asked at
/// collisions alone.
struct LampTrial {
  double variance_along = 0, variance_at_collisions = 0;  ///< of a sample
  double time = 1;  ///< of a sample along flights, over one at collisions: about
};

/// By so many small pictures each way, of all of the picture whatever part of it is rendered
/// (THEORY.md, T5.25). Lamps are asked along flights as the plan has it, whose kernel, lighting and
/// emission must be chosen. Deterministic.
[[nodiscard]] LampTrial try_lamps(const RenderPlan& plan, int passes = 8);

}  // namespace pvol::detail
