// Guided paths through fields with micro-bounds.
#include "render/guide/guided_tracer.h"
#include "render/tiles/render_tile.h"

namespace pvol::detail {
namespace {

template <LookUp kLookUp, int kEdge>
TileFunction choose(bool count) {
  using Field = MakeSqueezed<kLookUp, kEdge>;
  return count ? &render_tile<GuidedTracer<OneVolume<Field, Tally>>, true>
               : &render_tile<GuidedTracer<OneVolume<Field, NoTally>>, false>;
}

template <LookUp kLookUp>
TileFunction choose(int edge, bool count) {
  return edge == 1 ? choose<kLookUp, 1>(count) : choose<kLookUp, 2>(count);
}

}  // namespace

TileFunction guided_squeezed_tile_function(LookUp look_up, int edge, bool count) {
  return look_up == LookUp::nearest ? choose<LookUp::nearest>(edge, count)
                                    : choose<LookUp::trilinear>(edge, count);
}

}  // namespace pvol::detail
