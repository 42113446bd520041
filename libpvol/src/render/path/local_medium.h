// What a medium is where a path collided with it.
#pragma once

#include "render/path/path_setup.h"

namespace pvol::detail {

/// By which albedos are multiplied at a place, at a time: the colour there moves with the density.
/// Of volumes whose albedo is no field 1.
[[nodiscard]] Rgb local_color(const CollisionPlace& place, float time);

/// The medium there, on average over its components.
[[nodiscard, gnu::noinline]] LocalMedium local_medium(const CollisionPlace& place, float time);

}  // namespace pvol::detail
