// Paths through recipes without samples, with micro-bounds or without.
#include "render/tiles/render_tile.h"

namespace pvol::detail {

TileFunction procedural_tile_function(int edge, bool many, bool count) {
  return tile_function_of<LookUp::procedural>(edge, many, count);
}

}  // namespace pvol::detail
