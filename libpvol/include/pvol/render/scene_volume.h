// Volumes for a scene.
#pragma once

#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// What the volumes of a scene with these options are made for, but for their placement.
[[nodiscard]] VolumeOptions volume_options(const RenderOptions& options);

}  // namespace pvol
