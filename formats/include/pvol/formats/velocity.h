// Velocities of clouds, from .vdb and .pvol files and from recipes.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pvol/density/velocity_grid.h"
#include "pvol/formats/vdb.h"

namespace pvol::formats {

struct LoadedVelocity {
  VelocityGrid grid;
  std::string name;                   ///< of the grid, or of the three
  std::vector<std::string> warnings;  ///< whole sentences for the user
};

/// Names that programs give velocities, in capitals or not.
inline constexpr std::string_view kUsualVelocities[] = {"v", "vel", "velocity"};

/// The velocities of a .vdb file: the vector grid called `name` or, where there is none, three
/// grids of numbers called NAME.x, NAME_x or NAMEx and so on, in capitals or not, which must lie on
/// one lattice. Those of a .pvol file: the grids of velocity_parts(name). Those of a recipe: its
/// [flow], sampled as widely as its cloud and half as much around it, whatever the name. Without a
/// name the usual ones are looked for, in their order; then there may be none. Only active values
/// count, everything else is 0; values that are not finite are taken as 0, with a warning (refused
/// where `strict`). Throws Error for files of other kinds, damaged ones and those without a grid of
/// that name, with the grids that are there.
[[nodiscard]] std::optional<LoadedVelocity> read_velocity(const std::filesystem::path& file,
                                                          const std::string& name,
                                                          bool strict = false);

/// How .pvol files keep velocities: NAME.x+, NAME.x-, NAME.y+ and so on, the parts of
/// signed_parts().
[[nodiscard]] std::vector<std::string> velocity_parts(const std::string& name);

/// Whether these grids, of a .vdb or .pvol file, have velocities of that name.
[[nodiscard]] bool has_velocity(std::span<const GridEntry> grids, const std::string& name);

/// Whether a grid has the name of a component of such vectors: vel.x, vel_x or velx of vel.
[[nodiscard]] bool is_component(const std::string& grid, const std::string& vectors);

/// Of these grids the velocities of a usual name; "" where there are none.
[[nodiscard]] std::string usual_velocity(std::span<const GridEntry> grids);

}  // namespace pvol::formats
