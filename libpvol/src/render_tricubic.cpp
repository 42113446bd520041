// Paths through tricubic fields, with micro-bounds or without.
#include "render_tile.h"

namespace pvol::detail {

TileFunction tricubic_tile_function(int edge, bool many, bool count) {
  constexpr auto kInterpolation = Interpolation::tricubic;
  switch (edge) {
    case 1:
      return tile_function<MakeSqueezed<kInterpolation, 1>>(many, count);
    case 2:
      return tile_function<MakeSqueezed<kInterpolation, 2>>(many, count);
    default:
      return tile_function<MakePlain<kInterpolation>>(many, count);
  }
}

}  // namespace pvol::detail
