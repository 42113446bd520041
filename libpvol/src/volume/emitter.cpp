#include "pvol/volume/emitter.h"

#include <cmath>
#include <utility>

#include "pvol/bounds/map_pyramid.h"
#include "pvol/error.h"
#include "pvol/field/brick_field.h"
#include "volume/field_checks.h"
#include "volume/placement.h"

namespace pvol {
namespace {

VolumeField make_field(const BoundedGrid& from, const FieldMap& map,
                       const Affine& object_to_world) {
  const Pyramid& pyramid = from.pyramid;
  if (!pyramid.empty() && !holds_for(pyramid.look_up, LookUp::trilinear)) {
    throw Error(std::string("the bounds of ") + from.grid.name + " were made for " +
                name(pyramid.look_up) + " interpolation; those of fires are trilinear");
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
  f.octree = build_octree(mapped, 1, std::cbrt(std::abs(determinant(to_world))),
                          {.depth = kDeepestOctree, .costs = {}},
                          links_of(mapped, pyramid, built.brick_of), kZeroBrick);
  f.values = std::make_shared<const BrickField>(std::move(built.field));
  return f;
}

/// The point of a field at a place of the world; nothing outside its support.
std::optional<LatticePoint> point_of(const VolumeField& f, Vec3d world) {
  if (f.octree.empty()) return std::nullopt;
  const Vec3d cells = f.world_to_cells.point(world);
  if (!f.octree.support().contains(cells)) return std::nullopt;
  return make_cursor(f.octree, cells).at;
}

}  // namespace

float value_at(const VolumeField& f, Vec3d world) {
  const auto p = point_of(f, world);
  if (!p) return 0;
  constexpr LeafHandle kRoot = Octree::kNodeBit;
  return density<LookUp::trilinear>(f.bricks(), f.octree, kRoot, *p);
}

Emitter make_emitter(const Fire& fire, const BoundedGrid& field, const BoundedGrid* color_by,
                     const Affine& object_to_world) {
  validate(fire);
  Emitter e{.fire = fire, .field = make_field(field, fire.map, object_to_world)};
  if (color_by != nullptr && fire.colored()) {
    e.color_by = make_field(*color_by, {}, object_to_world);
  }
  return e;
}

Rgb emission_at(const Emitter& e, Vec3d world) {
  const float value = value_at(e.field, world);
  return emission(e.fire, value, e.color_by ? value_at(*e.color_by, world) : value);
}

}  // namespace pvol
