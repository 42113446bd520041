#include "volume/any_source.h"

namespace pvol::detail {

float density_at_time(const VolumeField& field, LeafHandle leaf, const LatticePoint& p,
                      float time) {
  return visit_source(field, [&](const auto& still) -> float {
    const Vec3d from = place_at_rest(field, time, position(p));
    if (from == position(p)) return still.density(leaf, p);
    if (!field.octree.support().contains(from)) return 0;
    constexpr LeafHandle kRoot = Octree::kNodeBit;
    return still.density(kRoot, make_cursor(field.octree, from).at);
  });
}

}  // namespace pvol::detail
