// UsdGeomPointInstancer: each instance is scaled, turned and moved.
#include <fmt/format.h>

#include "file/invertible.h"
#include "usda/usda_stage.h"

namespace pvol::formats::detail {
namespace {

/// Numbers per instance at one time.
struct Points {
  std::vector<Vec3d> positions{}, scales{};
  std::vector<double> turns{};  ///< four each
};

Points points_of(const UsdView& view, std::size_t count) {
  Points p{view.vectors("positions"), view.vectors("scales"), view.numbers("orientations", 4)};
  const auto fits = [&](std::size_t n) { return n == 0 || n == count; };
  if (p.positions.size() != count || !fits(p.scales.size()) || !fits(p.turns.size() / 4)) {
    fail_at(view.where(),
            fmt::format("{} positions, {} orientations and {} scales for {} protoIndices",
                        p.positions.size(), p.turns.size() / 4, p.scales.size(), count),
            "as many");
  }
  return p;
}

Affine place_of(const Points& p, std::size_t i) {
  Affine place = translation(p.positions[i]);
  if (!p.turns.empty()) {
    const double* q = &p.turns[4 * i];
    place = place * turn_of({q[0], q[1], q[2], q[3]});
  }
  return p.scales.empty() ? place : place * scaling(p.scales[i]);
}

}  // namespace

std::vector<std::vector<UsdPlace>> instances_of(const UsdView& view, std::size_t prototypes) {
  const std::vector<double> indices = view.numbers("protoIndices");
  const Points now = points_of(view, indices.size());
  const Points later = points_of(UsdView(view.prim(), view.frame() + 1), indices.size());
  std::vector<std::vector<UsdPlace>> places(prototypes);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const double index = indices[i];
    if (!(index >= 0 && index < double(prototypes))) {
      fail_at(view.where(), fmt::format("{} in protoIndices", index),
              fmt::format("0 to {}, for as many prototypes", double(prototypes) - 1));
    }
    const UsdPlace place{place_of(now, i), place_of(later, i)};
    if (is_invertible(place.now) && is_invertible(place.later)) {
      places[std::size_t(index)].push_back(place);
    }
  }
  return places;
}

}  // namespace pvol::formats::detail
