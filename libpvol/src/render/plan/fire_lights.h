// Whether it pays to sample fires as lights.
#pragma once

#include "pvol/render/plan.h"

namespace pvol::detail {

/// The plan's emission, sampled as a light at collisions only where that saves more noise than it
/// takes time: by a few paths of the camera with it, whose samples tell what the noise would be
/// without (THEORY.md, T5.12). Needs the kernel of the plan. Deterministic.
[[nodiscard]] std::shared_ptr<const EmissionSetup> choose_fire_lights(const RenderPlan& plan);

}  // namespace pvol::detail
