// Where a scene names a file that is not there.
#pragma once

#include <filesystem>

#include "pvol/error.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// Called where an Error is handled that loading `scene`, of the file `input`, threw: throws it
/// again. If it names a file of the scene that is missing, or is none, its message begins with
/// where the scene names that.
[[noreturn]] void rethrow_with_place(const Error& e, const std::filesystem::path& input,
                                     const formats::SceneFile& scene);

}  // namespace pvol::cli
