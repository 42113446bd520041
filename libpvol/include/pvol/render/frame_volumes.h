// The camera that fills the picture with clouds.
#pragma once

#include <span>

#include "pvol/render/camera.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// A camera on volumes as they stand still: `frame` on the box around all (camera.h) from the
/// front, and from aslant, where a box has empty corners, on what they hold, to about 1/32 of a
/// volume.
[[nodiscard]] Camera frame_volumes(std::span<const Volume> volumes, double aspect,
                                   const Camera& like = {});

}  // namespace pvol
