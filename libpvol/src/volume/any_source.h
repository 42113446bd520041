// A source for fields of every kind, still or in motion: which look-ups they have is found at each.
#pragma once

#include "pvol/volume/extinction_source.h"
#include "pvol/volume/motion.h"

namespace pvol::detail {

/// Where the density at a place was at the files' time, both in cells from the octree's origin: of
/// what stands still, there.
[[nodiscard]] inline Vec3d place_at_rest(const VolumeField& field, float time, Vec3d cells) {
  if (field.motion == nullptr || time == 0) return cells;
  const Motion& motion = *field.motion;
  const Float4 d = motion.displacements.bricks.at(motion.cells_to_lattice.point(cells));
  return cells - Vec3d(vec3(d * splat(time)));
}

/// The density at a place of a leaf, at a time in frames; of what stands still at any.
[[nodiscard]] float density_at_time(const VolumeField& field, LeafHandle leaf,
                                    const LatticePoint& p, float time);

/// What look-ups read (track/field.h) at a time in frames. Refers to the field.
struct AnyExtinction {
  const VolumeField& field;
  float time = 0;

  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return field.scale * density(s.leaf, p);
  }
  /// Without the scale.
  [[nodiscard]] float density(LeafHandle leaf, const LatticePoint& p) const {
    return density_at_time(field, leaf, p, time);
  }
};

/// f(source), and its result, of what there is at a time: visit_source of what stands still.
template <class F>
decltype(auto) visit_source_at(const VolumeField& field, float time, const F& f) {
  return field.motion != nullptr ? f(AnyExtinction{field, time}) : visit_source(field, f);
}

}  // namespace pvol::detail
