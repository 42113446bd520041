#include "pvol/volume/value_field.h"

#include <cmath>
#include <string>
#include <utility>

#include "pvol/bounds/map_pyramid.h"
#include "pvol/error.h"
#include "pvol/field/brick_field.h"
#include "volume/cell_look_up.h"
#include "volume/field_checks.h"
#include "volume/placement.h"

namespace pvol {

VolumeField make_value_field(const BoundedGrid& from, const FieldMap& map,
                             const Affine& object_to_world, const char* whose) {
  const Pyramid& pyramid = from.pyramid;
  if (!pyramid.empty() && !holds_for(pyramid.look_up, LookUp::trilinear)) {
    throw Error(std::string("the bounds of ") + from.grid.name + " were made for " +
                name(pyramid.look_up) + " interpolation; expected trilinear bounds for " + whose);
  }
  detail::require_cover(from.grid, pyramid);
  const Affine to_world = object_to_world * from.grid.index_to_world;
  const Pyramid mapped = map_pyramid(pyramid, map);
  VolumeField f;
  f.name = from.grid.name;
  f.world_to_cells = translation(-Vec3d(pyramid.origin)) * inverse(to_world);
  f.world_box = mapped.empty() ? Box{} : transform(to_world, mapped.support());
  detail::check_placement(to_world, f.world_to_cells, f.world_box);
  FieldWithLinks built = build_field(from.grid, pyramid);
  // Points of a line are spread over segments: those of leaves make for little noise.
  f.octree =
      build_octree(mapped, 1, std::cbrt(std::abs(determinant(to_world))), {.everywhere = true},
                   links_of(mapped, pyramid, built.brick_of), kZeroBrick);
  f.values = std::make_shared<const BrickField>(std::move(built.field));
  f.leaves = detail::index_leaves_of(f);
  return f;
}

float value_in(const VolumeField& f, Vec3d cells) {
  if (f.octree.empty() || !f.octree.support().contains(cells)) return 0;
  const LatticePoint p = lattice_point(f.octree, cells);
  return density<LookUp::trilinear>(f.bricks(), f.octree, detail::leaf_at(f, p.cell), p);
}

}  // namespace pvol
