// Guided paths through fields in which every question is a look-up.
#include "render/guide/guided_tracer.h"
#include "render/tiles/render_tile.h"

namespace pvol::detail {
namespace {

template <LookUp kLookUp>
TileFunction choose(bool count) {
  using Field = MakePlain<kLookUp>;
  return count ? &render_tile<GuidedTracer<OneVolume<Field, Tally>>, true>
               : &render_tile<GuidedTracer<OneVolume<Field, NoTally>>, false>;
}

}  // namespace

TileFunction guided_tile_function(LookUp look_up, bool count) {
  return look_up == LookUp::nearest ? choose<LookUp::nearest>(count)
                                    : choose<LookUp::trilinear>(count);
}

}  // namespace pvol::detail
