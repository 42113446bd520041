// Velocities of .vdb files.
#pragma once

#include "pvol/formats/velocity.h"

namespace pvol::formats::detail {

/// As read_velocity, for the one kind of file.
[[nodiscard]] std::optional<LoadedVelocity> read_vdb_velocity(const std::filesystem::path& file,
                                                              const std::string& name, bool strict);

}  // namespace pvol::formats::detail
