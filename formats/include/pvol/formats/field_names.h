// Which grid of a file means what, by the names that simulators write.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pvol/formats/scene_file.h"
#include "pvol/formats/vdb.h"

namespace pvol::formats {

/// The grids of a .vdb, .nvdb, .pvol or recipe (.toml) file. Throws Error for what cannot be read.
[[nodiscard]] std::vector<GridEntry> grids_of(const std::filesystem::path& file);

/// Of these grids those from which a fire is made unless the scene names others: how much is
/// emitted and, where there is another one, which colour it has.
[[nodiscard]] std::vector<std::string> usual_fire_grids(std::span<const GridEntry> grids);

/// Whether a grid has the name of a fire's strength. Temperatures alone do not: smoke has them,
/// too.
[[nodiscard]] bool has_flames(std::span<const GridEntry> grids);

/// Whether a fire has no grid among these: neither of the name that the scene gives nor, where it
/// gives none, of a usual one.
[[nodiscard]] bool lacks_grid(const Fire& fire, std::span<const GridEntry> grids);

/// Whether no grid is called density, or only one that is 0 everywhere, and it is not plain which
/// other one is meant.
[[nodiscard]] bool lacks_density(std::span<const GridEntry> grids);

/// Chooses a volume's grids, as far as the scene leaves them open, by the names that Houdini,
/// EmberGen, Blender and Bifrost write, in capitals or not. A file with flames or heat and no
/// density, and a volume whose grid is kNoGrid, becomes a fire alone, of the colour of black bodies
/// where the scene does not describe it; so does the fire of a volume that shows fires (shows_fire),
/// beside its smoke. Returns what was bound, in whole sentences for the user; nothing where the
/// scene names all. Throws Error that lists the grids where a fire lacks one.
[[nodiscard]] std::vector<std::string> bind_fields(SceneVolume& volume,
                                                   std::span<const GridEntry> grids);

/// Chooses the grid of a volume's albedo where the scene leaves it open and the file has
/// colours of a usual name (usual_color_grid); kNoGrid stays. Returns what was bound as above.
/// Throws Error that lists the grids where the scene wants one and none has such a name.
[[nodiscard]] std::vector<std::string> bind_albedo(SceneVolume& volume,
                                                   std::span<const GridEntry> grids);

}  // namespace pvol::formats
