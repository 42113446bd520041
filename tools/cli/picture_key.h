// What a picture is of: parts with the same key belong together.
#pragma once

#include <string>

#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// A hash of the scene, with nothing left to choose, and of the contents of its files, wherever
/// those are. It knows nothing of what leaves pictures the same on average: the seed, the samples,
/// how they are made; nor of the crop. Throws Error for a file that cannot be read.
[[nodiscard]] std::string picture_key(const formats::SceneFile& scene);

}  // namespace pvol::cli
