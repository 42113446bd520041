// Paths through nearest and trilinear fields in which every question is a look-up.
#include "render/tiles/render_tile.h"

namespace pvol::detail {
TileFunction plain_tile_function(LookUp look_up, bool many, bool count) {
  return look_up == LookUp::nearest ? tile_function<MakePlain<LookUp::nearest>>(many, count)
                                    : tile_function<MakePlain<LookUp::trilinear>>(many, count);
}

}  // namespace pvol::detail
