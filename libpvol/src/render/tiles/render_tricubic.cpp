// Paths through tricubic fields, with micro-bounds or without.
#include "render/tiles/render_tile.h"

namespace pvol::detail {

TileFunction tricubic_tile_function(int edge, bool many, bool count) {
  return tile_function_of<LookUp::tricubic>(edge, many, count);
}

}  // namespace pvol::detail
