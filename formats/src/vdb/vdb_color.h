// Colours of .vdb files.
#pragma once

#include "pvol/formats/color.h"

namespace pvol::formats::detail {

/// read_color of a .vdb file.
[[nodiscard]] LoadedColor read_vdb_color(const std::filesystem::path& file, const std::string& name,
                                         bool strict);

}  // namespace pvol::formats::detail
