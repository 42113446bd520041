// Colours of clouds, from .vdb and .pvol files.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pvol/density/color_grid.h"
#include "pvol/formats/vdb.h"

namespace pvol::formats {

/// A grid of colours, with what reading met: counts are of components of active voxels.
struct LoadedColor {
  ColorGrid grid;
  GridReport report;
};

/// Of these grids the one of colours that a file calls by a usual name: Cd, color, colour or
/// albedo, in capitals or not, in this order; "" where there is none. Colours are grids of vectors,
/// or three grids of numbers NAME.x, NAME.y and NAME.z, as .pvol files keep them.
[[nodiscard]] std::string usual_color_grid(std::span<const GridEntry> grids);

/// Whether these grids have colours of that name.
[[nodiscard]] bool has_colors(std::span<const GridEntry> grids, const std::string& name);

/// The colours of a .vdb or .pvol file. In a .vdb file active voxels say a colour, all others and
/// the background none. Components are taken into [0, 1], those that are not finite as 0, with a
/// warning that counts them (refused where `strict`). Throws Error for files of other kinds,
/// damaged ones and those without such a grid, with the grids that are there.
[[nodiscard]] LoadedColor read_color(const std::filesystem::path& file, const std::string& name,
                                     bool strict = false);

/// How .pvol files keep colours: three grids, and where black samples say a colour, a fourth one.
/// The last is for `black_of`.
[[nodiscard]] std::vector<std::string> color_parts(const std::string& name);

}  // namespace pvol::formats
