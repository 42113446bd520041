// What a render will take.
#pragma once

#include "pvol/render/plan.h"

namespace pvol::detail {

/// For a plan whose choices are made; see Forecast.
[[nodiscard]] Forecast forecast(const RenderPlan& plan);

}  // namespace pvol::detail
