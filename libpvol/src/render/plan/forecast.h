// The work of a render, and what work costs.
#pragma once

#include "render/plan/camera_probe.h"

namespace pvol::detail {

/// For a plan whose choices are made, by what a few of its paths meet; see Forecast.
[[nodiscard]] Forecast forecast(const RenderPlan& plan, const CameraProbe& probe);

/// Seconds of so many paths with these counts, if they were followed one by one.
[[nodiscard]] double seconds_of(const Counts& counts, int paths);

/// Nanoseconds of flights that end in about as many collisions as there are of them.
[[nodiscard]] double nanoseconds(const Tally& t, std::uint64_t flights);

/// Nanoseconds of the density with which fires are sampled as lights in one direction.
inline constexpr double kDirectionsPdf = 200;

/// Of that, what kernels take for the same paths.
[[nodiscard]] double share_of_time(KernelKind kernel);

}  // namespace pvol::detail
