// UsdGeomPointInstancer: each instance is scaled, turned and moved.
#include <fmt/format.h>

#include <set>
#include <vector>

#include "file/invertible.h"
#include "usda/usda_stage.h"

namespace pvol::formats::detail {
namespace {

/// Numbers per instance at one time.
struct Points {
  std::vector<double> prototypes{}, ids{};
  std::vector<Vec3d> positions{}, scales{};
  std::vector<double> turns{};  ///< four each
};

Points points_of(const UsdView& view) {
  return {view.numbers("protoIndices"), view.numbers("ids"), view.vectors("positions"),
          view.vectors("scales"), view.numbers("orientations", 4)};
}

/// Whether all of them are there for each instance. Only the positions must be.
bool are_whole(const Points& p) {
  const std::size_t count = p.prototypes.size();
  const auto fits = [&](std::size_t n) { return n == 0 || n == count; };
  return p.positions.size() == count && fits(p.ids.size()) && fits(p.scales.size()) &&
         fits(p.turns.size() / 4);
}

void refuse_parts(const Points& p, const UsdWhere& where) {
  if (are_whole(p)) return;
  fail_at(where,
          fmt::format("{} positions, {} orientations, {} scales and {} ids for {} protoIndices",
                      p.positions.size(), p.turns.size() / 4, p.scales.size(), p.ids.size(),
                      p.prototypes.size()),
          "as many");
}

/// The same instances a frame later; those of now, and that is named, where others are there then.
Points later_points_of(const UsdView& view, const Points& now, ImportNotes& notes) {
  Points later = points_of(UsdView(view.prim(), view.frame() + 1));
  const bool are_same = later.prototypes.size() == now.prototypes.size() && later.ids == now.ids;
  if (are_whole(later) && are_same) return later;
  notes.add(view.where(), fmt::format("the motion of the instances of \"{}\" is left out: they are "
                                      "others a frame later",
                                      usd_shown(view.prim().name)));
  return now;
}

/// Ids of instances that are not there.
std::set<double> hidden_ids(const UsdView& view) {
  const std::vector<double> inactive = items_of(view.prim().inactive);
  const std::vector<double> invisible = view.numbers("invisibleIds");
  std::set<double> all(inactive.begin(), inactive.end());
  all.insert(invisible.begin(), invisible.end());
  return all;
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

std::vector<std::vector<UsdPlace>> instances_of(const UsdView& view, std::size_t prototypes,
                                                ImportNotes& notes) {
  const Points now = points_of(view);
  refuse_parts(now, view.where());
  const Points later = later_points_of(view, now, notes);
  const std::set<double> hidden = hidden_ids(view);
  std::vector<std::vector<UsdPlace>> places(prototypes);
  for (std::size_t i = 0; i < now.prototypes.size(); ++i) {
    const double index = now.prototypes[i];
    if (!(index >= 0 && index < double(prototypes))) {
      fail_at(view.where(), fmt::format("{} in protoIndices", index),
              fmt::format("0 to {}, for as many prototypes", double(prototypes) - 1));
    }
    if (hidden.contains(now.ids.empty() ? double(i) : now.ids[i])) continue;
    const UsdPlace place{place_of(now, i), place_of(later, i)};
    if (is_invertible(place.now) && is_invertible(place.later)) {
      places[std::size_t(index)].push_back(place);
    }
  }
  return places;
}

}  // namespace pvol::formats::detail
