#include "render/scene/outline.h"

#include "bounds/octree_children.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"

namespace pvol::detail {
namespace {

constexpr std::size_t kManyPlaces = 64;

void add_corners(const Box& cells, const Affine& to_world, std::vector<Vec3d>& points) {
  for (unsigned k = 0; k < 8; ++k) points.push_back(to_world.point(corner(cells, k)));
}

/// Cubes that are not empty, as far as they are longer than `edge` cells, and those below them.
void add_cubes(const Octree& tree, const Octree::Node& node, Vec3i low, int edge,
               const Affine& to_world, std::vector<Vec3d>& points) {
  for_children(tree, node, low, [&](const Octree::Entry& e, Vec3i at, int length) {
    if ((e.link & Octree::kNodeBit) != 0 && length > edge) {
      return add_cubes(tree, tree.nodes[e.link & ~Octree::kNodeBit], at, edge, to_world, points);
    }
    const Box cube{max(Vec3d(at), tree.support().lo),
                   min(Vec3d(at + Vec3i(length)), tree.support().hi)};
    if (!cube.empty()) add_corners(cube, to_world, points);
  });
}

void add_field(const VolumeField& field, const Volume& v, std::vector<Vec3d>& points) {
  const Octree& tree = field.octree;
  if (tree.empty()) return;
  const std::size_t places = count_places(v);
  for (std::size_t place = 0; place < places; ++place) {
    const Affine to_world = inverse(field.world_to_cells * to_first_place(v, place));
    if (places > kManyPlaces) {
      add_corners(tree.support(), to_world, points);
      continue;
    }
    constexpr double kParts = 32;
    const int edge = int(max_component(tree.support().extent()) / kParts);
    add_cubes(tree, tree.nodes.front(), {}, edge, to_world, points);
  }
}

}  // namespace

std::vector<Vec3d> outline(std::span<const Volume> volumes) {
  std::vector<Vec3d> points;
  for (const Volume& v : volumes) {
    add_field(v.density, v, points);
    if (v.fire != nullptr) add_field(v.fire->field, v, points);
  }
  return points;
}

}  // namespace pvol::detail
