// What may be rendered.
#pragma once

#include <span>

#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// Throws Error, which says what is wrong, for a scene with values out of range, and for volumes
/// that do not go with it or with each other.
void check(std::span<const Volume> volumes, const Scene& scene);

}  // namespace pvol::detail
