// Guided paths through fields in which every question is a look-up.
#include "render/guide/guided_tracer.h"
#include "render/tiles/render_tile.h"

namespace pvol::detail {
namespace {

template <Interpolation kInterpolation>
TileFunction choose(bool count) {
  using Field = MakePlain<kInterpolation>;
  return count ? &render_tile<GuidedTracer<OneVolume<Field, Tally>>, true>
               : &render_tile<GuidedTracer<OneVolume<Field, NoTally>>, false>;
}

}  // namespace

TileFunction guided_tile_function(Interpolation interpolation, bool count) {
  return interpolation == Interpolation::nearest ? choose<Interpolation::nearest>(count)
                                                 : choose<Interpolation::trilinear>(count);
}

}  // namespace pvol::detail
