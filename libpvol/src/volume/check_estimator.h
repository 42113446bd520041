// Which estimators embedders may ask for.
#pragma once

#include "pvol/volume/volume.h"

namespace pvol::detail {

/// Throws Error for `automatic`, which is chosen once for a volume, and for closed forms of volumes
/// that have none.
void check_estimator(const Volume& volume, Transmittance estimator);

}  // namespace pvol::detail
