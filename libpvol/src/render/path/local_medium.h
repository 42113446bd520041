// What a component of a medium is where a path collided with it.
#pragma once

#include "render/path/path_setup.h"

namespace pvol::detail {

/// The component at a place, at a time: the colour there moves with the density. Of volumes whose
/// albedo is no field, what it is everywhere.
[[nodiscard, gnu::noinline]] LocalMedium local_medium(const CollisionPlace& place,
                                                      const MediumComponent& component, float time);

}  // namespace pvol::detail
