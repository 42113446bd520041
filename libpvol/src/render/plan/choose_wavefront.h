// Which kernel follows the paths of a scene.
#pragma once

#include <span>

#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"
#include "volume/simd/choose_batch_kernels.h"

namespace pvol::detail {

/// The most lanes that the machine and the scene allow, or what the options say. Throws Error where
/// they name a kernel that cannot render it. `volumes` were checked.
[[nodiscard]] KernelChoice choose_wavefront(std::span<const Volume> volumes, const Scene& scene);

}  // namespace pvol::detail
