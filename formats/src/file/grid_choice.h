// Which grid of a file is the density, the same for every format.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pvol/formats/vdb.h"

namespace pvol::formats::detail {

struct GridChoice {
  std::string name;     ///< unique in the file: "density", "density[1]" where a name occurs again
  std::string base;     ///< without the index; may be empty
  std::string type;     ///< for people, e.g. "half", "vec3s", "float, level set"
  std::string refusal;  ///< why it cannot be a density ("it holds vectors"); empty where it can
};

/// "density (float), v (vec3s)", at most a dozen of them.
[[nodiscard]] std::string list_grids(const std::vector<GridChoice>& grids);

/// The same for users of the library.
[[nodiscard]] std::vector<GridEntry> entries_of(const std::vector<GridChoice>& grids);

/// Index of the grid called `wanted`; without a name that of "density", else of the only grid that
/// can be one. Adds a warning where the name occurs several times and the first one is taken.
/// Throws Error that lists the grids where none or several fit, or says why the one asked for does
/// not.
[[nodiscard]] std::size_t choose_grid(const std::filesystem::path& file,
                                      const std::vector<GridChoice>& grids,
                                      const std::string& wanted,
                                      std::vector<std::string>& warnings);

/// Warns where the grid that nobody named turned out to be empty and others are there.
void warn_of_others(const std::vector<GridChoice>& grids, const GridOptions& options,
                    GridReport& report);

/// Text from a file as messages show it: control characters replaced, at most 80 bytes.
[[nodiscard]] std::string printable(const std::string& text);

}  // namespace pvol::formats::detail
