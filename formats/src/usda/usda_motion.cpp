#include "usda/usda_world.h"

namespace pvol::formats::detail {

std::optional<MovingPlacement> motion_of(const UsdPlace& place, const UsdItem& of,
                                         const UsdMaking& making) {
  if (!place.moves()) return std::nullopt;
  MovingPlacement moving;
  moving.from.matrix = place.now, moving.to.matrix = place.later;
  if (!misfit(moving)) return moving;
  making.note(of.prim->where,
              "the motion of " + usd_shown(of.path) +
                  " is left out: no way leads from where it is to where it is a frame later");
  return std::nullopt;
}

}  // namespace pvol::formats::detail
