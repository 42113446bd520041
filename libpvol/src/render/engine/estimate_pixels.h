// How bright the pixels of an image will be, before it is rendered.
#pragma once

#include <memory>

#include "render/path/path_setup.h"

namespace pvol::detail {

/// By a small image of the same paths, of about 1/64 of the samples, which is thrown away: that of
/// the whole image, whatever part of it is rendered. Null where there are too few samples for that,
/// or the camera sees no matter. Deterministic for any number of threads; of no use once the setup
/// says stop.
[[nodiscard]] std::shared_ptr<const PixelImportance> estimate_pixel_importance(
    const PathSetup& setup);

}  // namespace pvol::detail
