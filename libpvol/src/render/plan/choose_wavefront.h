// Which kernel follows the paths of a scene, and how flights through its volumes go.
#pragma once

#include "pvol/render/options.h"
#include "pvol/volume/volume.h"
#include "volume/simd/choose_batch_kernels.h"

namespace pvol::detail {

/// The most lanes that the machine has, or what is wanted. Throws Error where the machine has not
/// got that, or no lanes at all.
[[nodiscard]] KernelChoice choose_wavefront(KernelKind wanted);

/// Why flights through a volume go one by one, along walks through its octree, or null: many go at
/// once, in lanes. All else that paths do goes in lanes in any case.
[[nodiscard]] const char* why_one_by_one(const Volume& volume, const RenderOptions& options);

}  // namespace pvol::detail
