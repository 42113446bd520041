// The inner part of a render: samples of the pixels of a tile.
#pragma once

#include "render/path/path_setup.h"

namespace pvol::detail {

/// Adds samples [begin, end) of every pixel of a tile, a part of the film, to it and their counts
/// to `counts`, where the setup counts. Returns false, and leaves out what is under way, once the
/// setup says stop.
using TileFunction = bool (*)(const PathSetup&, const ImagePart& tile, std::uint32_t begin,
                              std::uint32_t end, Film&, Counts& counts);

[[nodiscard]] TileFunction find_tile_function(Paths paths);

}  // namespace pvol::detail
