// Paths through nearest and trilinear fields in which every question is a look-up.
#include "render/tiles/render_tile.h"

namespace pvol::detail {
TileFunction plain_tile_function(Interpolation interpolation, bool many, bool count) {
  return interpolation == Interpolation::nearest
             ? tile_function<MakePlain<Interpolation::nearest>>(many, count)
             : tile_function<MakePlain<Interpolation::trilinear>>(many, count);
}

}  // namespace pvol::detail
