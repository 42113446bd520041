// What a render will take.
#pragma once

#include "render/plan/camera_probe.h"

namespace pvol::detail {

/// For a plan whose choices are made, by what a few of its paths meet; see Forecast.
[[nodiscard]] Forecast forecast(const RenderPlan& plan, const CameraProbe& probe);

/// Of the scalar tracers' time, what kernels take for the same paths.
[[nodiscard]] double share_of_time(KernelKind kernel);

}  // namespace pvol::detail
