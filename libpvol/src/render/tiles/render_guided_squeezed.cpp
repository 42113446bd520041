// Guided paths through fields with micro-bounds.
#include "render/guide/guided_tracer.h"
#include "render/tiles/render_tile.h"

namespace pvol::detail {
namespace {

template <Interpolation kInterpolation, int kEdge>
TileFunction choose(bool count) {
  using Field = MakeSqueezed<kInterpolation, kEdge>;
  return count ? &render_tile<GuidedTracer<OneVolume<Field, Tally>>, true>
               : &render_tile<GuidedTracer<OneVolume<Field, NoTally>>, false>;
}

template <Interpolation kInterpolation>
TileFunction choose(int edge, bool count) {
  return edge == 1 ? choose<kInterpolation, 1>(count) : choose<kInterpolation, 2>(count);
}

}  // namespace

TileFunction guided_squeezed_tile_function(Interpolation interpolation, int edge, bool count) {
  return interpolation == Interpolation::nearest ? choose<Interpolation::nearest>(edge, count)
                                                 : choose<Interpolation::trilinear>(edge, count);
}

}  // namespace pvol::detail
