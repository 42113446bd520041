// Points around what volumes hold.
#pragma once

#include <span>
#include <vector>

#include "pvol/volume/volume.h"

namespace pvol::detail {

/// Corners of cubes of the octrees, those of density and of fires, at all places of the volumes as
/// they stand still: all that is not empty lies among them. A cube has about 1/32 of its volume's
/// extent; of volumes at many places boxes alone are taken.
[[nodiscard]] std::vector<Vec3d> outline(std::span<const Volume> volumes);

}  // namespace pvol::detail
