// What takes OpenVDB. It is in a module of its own, pvol_vdb.so, which is loaded at the first .vdb
// file: to link OpenVDB takes a tenth of a second, ten times as long as all else that a tool does
// to start.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pvol/formats/color.h"
#include "pvol/formats/vdb.h"
#include "pvol/formats/velocity.h"

namespace pvol::formats::detail {

/// read_vdb, within the module.
[[nodiscard]] LoadedGrid read_vdb_density(const std::filesystem::path& file,
                                          const GridOptions& options);

/// read_color of a .vdb file.
[[nodiscard]] LoadedColor read_vdb_color(const std::filesystem::path& file, const std::string& name,
                                         bool strict);

/// read_velocity of a .vdb file.
[[nodiscard]] std::optional<LoadedVelocity> read_vdb_velocity(const std::filesystem::path& file,
                                                              const std::string& name, bool strict);

/// Writes grids to a file that is there to be filled, as long as they live. `name` is what messages
/// call it. Throws Error where there is not memory enough.
[[nodiscard]] std::function<void(const std::filesystem::path& file)> vdb_writer(
    const std::string& name, const std::vector<const VoxelGrid*>& grids,
    const std::vector<const ColorGrid*>& colors,
    const std::vector<const VelocityGrid*>& velocities);

/// The functions above, as the module shows them.
struct VdbCalls {
  decltype(&read_vdb_density) read_density;
  decltype(&read_vdb_color) read_color;
  decltype(&read_vdb_velocity) read_velocity;
  decltype(&vdb_writer) writer;
};

/// Those of the module, which the first call loads. Throws Error, which names the file that is
/// asked for, where there is no module or no OpenVDB.
[[nodiscard]] const VdbCalls& vdb_calls(const std::filesystem::path& file);

}  // namespace pvol::formats::detail
