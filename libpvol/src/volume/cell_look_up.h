// Look-ups in a volume's cells, wherever in the world these are.
#pragma once

#include "pvol/bounds/leaf_index.h"
#include "pvol/field/brick_field.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// mu_t at a place in cells from the octree's origin, at a time in frames; 0 outside the support.
[[nodiscard]] float extinction_in_cells(const Volume& volume, Vec3d cells, float time = 0);

/// The index of a field's leaves for its octree and values; null where it would take more than 1/50
/// of the values' bytes: a few clouds far apart.
[[nodiscard]] inline std::shared_ptr<const LeafIndex> index_leaves_of(const VolumeField& f) {
  return index_leaves(f.octree, f.value_bytes() / 50);
}

/// From where to look for the samples at a cell of the support: their brick, or the octree's root.
[[nodiscard]] inline LeafHandle leaf_at(const VolumeField& f, Int4 cell) {
  return f.leaves != nullptr ? f.leaves->brick_at(cell) : Octree::kNodeBit;
}

/// Whether lanes look up a field's values: what stands still, has an index of its leaves, and
/// samples that 31 bits number.
[[nodiscard]] inline bool has_values_in_lanes(const VolumeField& f) {
  return f.motion == nullptr && f.look_up == LookUp::trilinear && !f.shares_samples() &&
         f.leaves != nullptr && f.bricks().samples.size() >> 31 == 0;
}
/// The same of all that a fire asks for.
[[nodiscard]] inline bool has_values_in_lanes(const Emitter& fire) {
  return has_values_in_lanes(fire.field) && (!fire.color_by || has_values_in_lanes(*fire.color_by));
}

}  // namespace pvol::detail
