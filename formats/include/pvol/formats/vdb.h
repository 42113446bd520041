// Reading and writing OpenVDB files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/color_grid.h"
#include "pvol/density/velocity_grid.h"
#include "pvol/density/voxel_grid.h"

namespace pvol::formats {

struct GridOptions {
  /// Name of the grid; empty: "density", else the only grid that can be a density. Where a name
  /// occurs several times, the first such grid is taken with a warning; an index tells them apart:
  /// "density[1]".
  std::string grid;
  bool strict =
      false;  ///< refuse non-finite and negative values, and whatever else draws a warning
};

/// What reading met. Counts are of active voxels, tiles counted by their volume.
struct GridReport {
  std::string grid;                   ///< unique name of the grid in the file
  std::string type;                   ///< as in the file: "float", "half", "double", "fp8", ...
  std::uint64_t active = 0;           ///< active voxels
  std::uint64_t non_finite = 0;       ///< NaN or infinite, replaced by 0
  std::uint64_t negative = 0;         ///< below 0, replaced by 0
  float largest = 0;                  ///< largest density kept
  std::vector<std::string> warnings;  ///< whole sentences for the user
};

struct LoadedGrid {
  VoxelGrid grid;
  GridReport report;
};

/// A grid of a file, as far as its name and type say.
struct GridEntry {
  std::string name;    ///< unique in the file
  std::string type;    ///< "float", "half", "vec3s", ...
  bool usable = true;  ///< whether it holds numbers that can be a density or an emission
};

/// Where the module lies that calls OpenVDB; it is loaded when a .vdb file is first used. Nothing
/// where it is not installed.
[[nodiscard]] std::optional<std::filesystem::path> vdb_module_folder();

/// The grids of a .vdb or .nvdb file, in its order. Throws Error for files that cannot be read.
[[nodiscard]] std::vector<GridEntry> list_vdb(const std::filesystem::path& file);
[[nodiscard]] std::vector<GridEntry> list_nvdb(const std::filesystem::path& file);

/// The density grid of a .vdb file of format version 222 (OpenVDB 1.1) to 224 (OpenVDB 12). Only
/// active values count: inactive voxels and the background are 0, with a warning where the file
/// holds something else there. Values stay where OpenVDB loads them, and other grids are not
/// loaded: memory is that of the grid. A grid without any density above 0 is empty, with a warning.
/// The structure of the whole grid is checked before OpenVDB reads it, so that damage is found as
/// far as it can be: the format has no checksums, and a changed value looks like any other.
/// Throws Error for files that are damaged, cut off, of another version or hold no usable grid
/// (level sets, integer, bool, vector and point grids, frustum and singular maps), with the grids
/// that are there.
[[nodiscard]] LoadedGrid read_vdb(const std::filesystem::path& file,
                                  const GridOptions& options = {});

/// The same for a NanoVDB file (.nvdb) of version 32, plain or compressed, with float, double, fp4,
/// fp8, fp16 or fpN values. The values are copied.
[[nodiscard]] LoadedGrid read_nvdb(const std::filesystem::path& file,
                                   const GridOptions& options = {});

/// Writes fog-volume grids to one .vdb file, atomically (aside, then renamed), and after them grids
/// of colours and of velocities, which are called as their components are. Samples of value 0, and
/// those that say no colour, are inactive. The same grids give the same bytes: the file's UUID is
/// made from its content. Throws Error where the file cannot be written, or for a map that OpenVDB
/// does not take (voxels below about 1e-5).
void write_vdb(const std::filesystem::path& file, const std::vector<const VoxelGrid*>& grids,
               const std::vector<const ColorGrid*>& colors = {},
               const std::vector<const VelocityGrid*>& velocities = {});

}  // namespace pvol::formats
