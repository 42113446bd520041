// Fields beside the density, which have places of their own.
#pragma once

#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/math/field_map.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// A grid with its bounds.
struct BoundedGrid {
  const VoxelGrid& grid;
  const Pyramid& pyramid;
};

/// Makes a grid ready for trilinear look-ups and for walks, which stop at leaves: its octree bounds
/// the mapped values, its values are the grid's own. Placed by object_to_world after the grid's own
/// map. Throws Error for a placement out of range, for bounds that do not hold or were made for
/// another interpolation than that of `whose` ("fires"), and for a map of 0 to something else.
[[nodiscard]] VolumeField make_value_field(const BoundedGrid& from, const FieldMap& map,
                                           const Affine& object_to_world, const char* whose);

/// The value of a field of samples in cells from its octree's origin, without its scale; 0 outside.
[[nodiscard]] float value_in(const VolumeField& field, Vec3d cells);

/// The same at a place of the world.
[[nodiscard]] inline float value_at(const VolumeField& field, Vec3d world) {
  return value_in(field, field.world_to_cells.point(world));
}

}  // namespace pvol
