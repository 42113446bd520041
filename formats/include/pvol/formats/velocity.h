// Velocities of clouds, from .vdb files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/velocity_grid.h"

namespace pvol::formats {

struct LoadedVelocity {
  VelocityGrid grid;
  std::string name;                   ///< of the grid, or of the three
  std::vector<std::string> warnings;  ///< whole sentences for the user
};

/// The velocities of a .vdb file: the vector grid called `name` or, where there is none, three
/// grids of numbers called NAME.x, NAME_x or NAMEx and so on, in capitals or not, which must lie on
/// one lattice. Without a name v, vel and velocity are looked for, in this order; then there may be
/// none. Only active values count, everything else is 0; values that are not finite are taken as 0,
/// with a warning (refused where `strict`). Throws Error for files of other kinds, damaged ones and
/// those without a grid of that name, with the grids that are there.
[[nodiscard]] std::optional<LoadedVelocity> read_velocity(const std::filesystem::path& file,
                                                          const std::string& name,
                                                          bool strict = false);

}  // namespace pvol::formats
