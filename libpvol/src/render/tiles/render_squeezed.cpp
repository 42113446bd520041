// Paths through nearest and trilinear fields with micro-bounds.
#include "render/tiles/render_tile.h"

namespace pvol::detail {
namespace {

template <Interpolation kInterpolation>
TileFunction choose(int edge, bool many, bool count) {
  return edge == 1 ? tile_function<MakeSqueezed<kInterpolation, 1>>(many, count)
                   : tile_function<MakeSqueezed<kInterpolation, 2>>(many, count);
}

}  // namespace

TileFunction squeezed_tile_function(Interpolation interpolation, int edge, bool many, bool count) {
  return interpolation == Interpolation::nearest
             ? choose<Interpolation::nearest>(edge, many, count)
             : choose<Interpolation::trilinear>(edge, many, count);
}

}  // namespace pvol::detail
