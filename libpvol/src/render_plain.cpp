// Paths through fields in which every question is a look-up.
#include "render_tile.h"

namespace pvol::detail {
namespace {

template <Interpolation kInterpolation>
struct MakePlain {
  [[nodiscard]] auto operator()(const Volume& v) const {
    return PlainField{brick_extinction<kInterpolation>(v)};
  }
};

}  // namespace

TileFunction plain_tile_function(Interpolation interpolation, bool many, bool count) {
  return interpolation == Interpolation::nearest
             ? tile_function<MakePlain<Interpolation::nearest>>(many, count)
             : tile_function<MakePlain<Interpolation::trilinear>>(many, count);
}

}  // namespace pvol::detail
