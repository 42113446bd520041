// Paths through nearest and trilinear fields with micro-bounds.
#include "render/tiles/render_tile.h"

namespace pvol::detail {
namespace {

template <LookUp kLookUp>
TileFunction choose(int edge, bool many, bool count) {
  return edge == 1 ? tile_function<MakeSqueezed<kLookUp, 1>>(many, count)
                   : tile_function<MakeSqueezed<kLookUp, 2>>(many, count);
}

}  // namespace

TileFunction squeezed_tile_function(LookUp look_up, int edge, bool many, bool count) {
  return look_up == LookUp::nearest ? choose<LookUp::nearest>(edge, many, count)
                                    : choose<LookUp::trilinear>(edge, many, count);
}

}  // namespace pvol::detail
