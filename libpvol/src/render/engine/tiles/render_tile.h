// The inner part of a render: samples of the pixels of a tile.
#pragma once

#include "render/engine/tiles/sample_targets.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// Adds samples to every pixel of a tile, a part of the film, up to its target, and their counts to
/// `counts`, where the setup counts. A pixel's samples are numbered from the film's first_sample
/// on. Returns false, and leaves out what is under way, once the setup says stop.
using TileFunction = bool (*)(const PathSetup&, const ImagePart& tile, const SampleTargets&, Film&,
                              Counts& counts);

[[nodiscard]] TileFunction find_tile_function(Paths paths, const PathSetup& setup);

}  // namespace pvol::detail
