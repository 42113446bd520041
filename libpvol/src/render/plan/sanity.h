// Pictures that no one would want to wait for, or to look at: refused, or rendered with a warning.
#pragma once

#include <string>
#include <vector>

#include "pvol/volume/facts.h"
#include "render/plan/camera_probe.h"

namespace pvol::detail {

/// Null collisions in one segment above which flights are refused, and not followed if insisted on.
inline constexpr double kMostNullCollisions = 1e6;
[[nodiscard]] inline bool has_endless_flights(const Volume& volume) {
  return worst_null_collisions(volume) > kMostNullCollisions;
}

/// Throws Error where a picture would take for ever, nearly: null collisions without number in
/// empty space under an enormous majorant and, by the facts if there are any, weights that grow
/// without end.
void refuse_endless_flights(const Volume& volume, const VolumeFacts* facts,
                            const RenderOptions& options);

/// The same for paths that scatter more often than kMostScatterings.
void refuse_endless_paths(const RenderPlan& plan, const CameraProbe& probe);

/// Whole sentences about what is likely to be a mistake: volumes thousands of free paths thick, or
/// next to none, and cameras that see nothing of them, or next to nothing.
[[nodiscard]] std::vector<std::string> find_warnings(const RenderPlan& plan,
                                                     const CameraProbe& probe);

}  // namespace pvol::detail
