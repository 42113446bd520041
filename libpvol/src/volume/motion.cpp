#include "pvol/volume/motion.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "bounds/octree_children.h"
#include "pvol/bounds/map_pyramid.h"
#include "pvol/error.h"
#include "pvol/field/brick_field.h"
#include "pvol/volume/moving_places.h"
#include "volume/cell_look_up.h"
#include "volume/placement.h"

namespace pvol {
namespace {

void require(bool ok, const char* message) {
  if (!ok) throw Error(std::string("a volume in motion ") + message);
}

void check(const Volume& v, const VolumeOptions& o) {
  require(o.look_up != LookUp::procedural,
          "needs samples; choose another interpolation than procedural");
  require(!o.homogenise && v.density.homogeneous == nullptr,
          "does not support homogenise; leave it off");
  require(o.majorant_scale == 1 && v.density.majorant_excess == 1 && v.density.excess.nodes == 0,
          "needs bounds that hold, without a factor; leave majorant_scale at 1, or fit the cloud "
          "again");
  require(o.tracker != Tracker::regular, "has no closed form; choose another tracker than regular");
}

/// The brick of each leaf of the swept pyramid as the still octree knows it: where nothing moves,
/// look-ups end there.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> links_of(const Pyramid& swept,
                                                               const Octree& still) {
  std::vector<std::vector<std::uint32_t>> links(swept.levels.size());
  if (swept.empty()) return links;
  const Vec3l shift = swept.origin - still.origin;
  const Vec3i lo = vec3(still.support_lo), hi = vec3(still.support_hi);
  for (const PyramidNode& leaf : swept.levels[0]) {
    const Vec3i at(shift + Vec3l(morton_decode(leaf.code)) * std::int64_t(kLeafEdge));
    const Vec3i end = at + Vec3i(kLeafEdge);
    const bool outside = at.x >= hi.x || at.y >= hi.y || at.z >= hi.z || end.x <= lo.x ||
                         end.y <= lo.y || end.z <= lo.z;
    links[0].push_back(outside ? kZeroBrick : detail::brick_of_leaf(still, widen(at), kZeroBrick));
  }
  return links;
}

/// Where a walk through moving density should stop: look-ups cost two searches from the root.
[[nodiscard]] Cut choose_cut(const VolumeOptions& o) {
  constexpr double kMovingCost = 100;
  Cut cut;
  cut.depth = o.tracker == Tracker::delta_global ? 0 : o.depth;
  cut.costs.lookup = kMovingCost;
  return cut;
}

/// Of a field of these bounds; null where nothing moves it.
[[nodiscard]] std::shared_ptr<Motion> make_motion(const Pyramid& pyramid,
                                                  const Affine& index_to_object,
                                                  const Movement& movement) {
  if (pyramid.empty()) return nullptr;
  auto motion = std::make_shared<Motion>();
  motion->shutter = movement.shutter;
  motion->displacements = make_displacements(movement.velocity, index_to_object, movement.seconds);
  const float largest = motion->displacements.largest;
  if (largest == 0) return nullptr;
  motion->longest = double(largest) * movement.shutter.farthest();
  motion->still_extent = max_component(pyramid.support().extent());
  return motion;
}

/// How a moving field is bounded: `map` is of its values, and they are `scale` times as large.
struct SweptTree {
  const FieldMap* map;
  double scale;
  Cut cut;
};

/// Sets a still field in motion, whose own map leads `to_world`.
void set_in_motion(VolumeField& f, const Pyramid& pyramid, const Affine& to_world,
                   const SweptTree& tree, std::shared_ptr<Motion> motion) {
  const Displacements& d = motion->displacements;
  Pyramid swept = sweep_bounds(pyramid, f, d, motion->shutter);
  if (tree.map != nullptr) swept = map_pyramid(swept, *tree.map);
  f.world_to_cells = translation(-Vec3d(swept.origin)) * inverse(to_world);
  f.world_box = transform(to_world, swept.support());
  detail::check_placement(to_world, f.world_to_cells, f.world_box);
  f.octree = build_octree(swept, tree.scale, std::cbrt(std::abs(determinant(to_world))), tree.cut,
                          links_of(swept, f.octree), kZeroBrick);
  f.leaves = detail::index_leaves_of(f);
  f.micro = {};
  f.codes.reset();
  f.micro_stored = false;
  motion->cells_to_lattice = d.index_to_cells * translation(Vec3d(swept.origin));
  f.motion = std::move(motion);
}

}  // namespace

Volume make_moving(Volume v, const Pyramid& pyramid, const Affine& index_to_object,
                   const Movement& movement, const VolumeOptions& o) {
  const bool opens = movement.shutter.moves();
  if (opens) check(v, o);
  auto motion = make_motion(pyramid, index_to_object, movement);
  if (motion == nullptr) return v;
  v.velocities = motion;
  if (!opens) {
    motion->cells_to_lattice =
        motion->displacements.index_to_cells * translation(Vec3d(v.density.octree.origin));
    return v;
  }
  set_in_motion(v.density, pyramid, v.object_to_world * index_to_object,
                {v.density.map.get(), v.medium.extinction, choose_cut(o)}, std::move(motion));
  v.shell = nullptr;
  return v;
}

Emitter make_moving(Emitter e, const BoundedGrid& field, const Affine& object_to_world,
                    const Movement& movement) {
  if (!movement.shutter.moves()) return e;
  const Affine& to_object = field.grid.index_to_world;
  auto motion = make_motion(field.pyramid, to_object, movement);
  if (motion == nullptr) return e;
  set_in_motion(e.field, field.pyramid, object_to_world * to_object,
                {&e.fire.map, 1, {.everywhere = true}}, std::move(motion));
  return e;
}

Vec3d velocity_at(const Volume& v, std::size_t place, const Affine& world_to_cells, Vec3d cells,
                  double frames) {
  Vec3d sum;
  if (const Motion* m = v.velocities.get()) {
    const Float4 d = m->displacements.bricks.at(m->cells_to_lattice.point(cells));
    sum = inverse(world_to_cells).vector(Vec3d(vec3(d)));
  }
  if (const MovingPlaces* m = v.place_velocities.get()) {
    const Vec3d p = cells_to_object(v.density, v).point(cells);
    const MovingPlace& at = m->all[place];
    const Vec3d by_object = at.instance.at(frames).vector(at.object.velocity(p, frames));
    sum += at.instance.velocity(at.object.at(frames).point(p), frames) + by_object;
  }
  return sum;
}

}  // namespace pvol
