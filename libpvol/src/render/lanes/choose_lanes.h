// Which kernel follows the paths of a scene.
#pragma once

#include <span>
#include <string>

#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

struct LaneChoice {
  Lanes lanes = Lanes::scalar;  ///< not automatic
  std::string reason;
};

/// The most lanes that the machine and the scene allow, or what the options say. Throws Error where
/// they name a kernel that cannot render it. `volumes` were checked.
[[nodiscard]] LaneChoice choose_lanes(std::span<const Volume> volumes, const Scene& scene);

/// Whether this machine and this build have such a kernel; `scalar` always.
[[nodiscard]] bool has_kernel(Lanes lanes);

}  // namespace pvol::detail
