// The field that trackers ask of a volume in motion.
#pragma once

#include <atomic>

#include "pvol/field/brick_field.h"
#include "pvol/volume/motion.h"

namespace pvol::detail {

/// Where the density at a place was at the files' time, both in cells from the octree's origin.
[[nodiscard]] inline Vec3d source_of(const Motion& motion, float time, Vec3d cells) {
  const Float4 d = motion.displacements.bricks.at(motion.cells_to_lattice.point(cells));
  return cells - Vec3d(vec3(d * splat(time)));
}

/// The density at a place of a leaf, at a time in frames; of what stands still at any.
template <LookUp kLookUp>
[[nodiscard]] float density_at_time(const VolumeField& field, LeafHandle leaf,
                                    const LatticePoint& p, float time) {
  const BrickExtinction<kLookUp> still{field.bricks(), field.octree, field.scale};
  if (field.motion == nullptr || time == 0) return still.density(leaf, p);
  const Vec3d source = source_of(*field.motion, time, position(p));
  if (source == position(p)) return still.density(leaf, p);
  if (!field.octree.support().contains(source)) return 0;
  constexpr LeafHandle kRoot = Octree::kNodeBit;
  return still.density(kRoot, make_cursor(field.octree, source).at);
}

/// Every question is a look-up of what is at the point at `time`. Other volumes of the scene may
/// stand still: theirs are plain. Ends flights once it is to stop, as a CancellableField does.
template <LookUp kLookUp>
struct AdvectedField {
  const VolumeField& field;
  float time;
  const std::atomic<bool>& stop;

  template <class Count>
  [[nodiscard]] float extinction(const Segment& s, const LatticePoint& p, Count& count) const {
    if (stop.load(std::memory_order_relaxed)) return s.hi;
    count.lookup();
    return field.scale * density_at_time<kLookUp>(field, s.leaf, p, time);
  }

  template <class Count>
  [[nodiscard]] bool exceeds(const Segment& s, const LatticePoint& p, float mu,
                             Count& count) const {
    if (stop.load(std::memory_order_relaxed)) return true;
    return mu < extinction(s, p, count);
  }
};

}  // namespace pvol::detail
