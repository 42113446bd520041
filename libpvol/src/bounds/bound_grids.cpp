#include "pvol/bounds/bound_grids.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "pvol/error.h"

namespace pvol {
namespace {

/// Bounds of the 8^3 cubes of one brick.
struct BoundBrick {
  std::array<float, kBrickSamples> lo{}, hi{};
};

struct Order {
  bool operator()(Vec3i a, Vec3i b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};

using Bricks = std::map<Vec3i, BoundBrick, Order>;

/// The lattice point of a leaf-sized cube, and the origin of the brick that holds it.
Vec3i brick_origin(Vec3i p) { return {p.x & ~7, p.y & ~7, p.z & ~7}; }

/// Gives all points of the cube [at, at + edge)^3 these bounds, brick by brick.
void fill(Bricks& bricks, Vec3i at, std::int32_t edge, const PyramidNode& node,
          std::uint64_t max_bricks) {
  const Vec3i end = at + Vec3i(edge), first = brick_origin(at);
  for (std::int32_t bx = first.x; bx < end.x; bx += kBrickEdge) {
    for (std::int32_t by = first.y; by < end.y; by += kBrickEdge) {
      for (std::int32_t bz = first.z; bz < end.z; bz += kBrickEdge) {
        const Vec3i origin(bx, by, bz);
        BoundBrick& brick = bricks[origin];
        if (bricks.size() > max_bricks) {
          throw Error("its bounds as voxels would take more than " + std::to_string(max_bricks) +
                      " bricks of 8^3; it holds huge uniform regions. Crop the volume or resample "
                      "it to larger voxels");
        }
        const Vec3i lo = max(at - origin, Vec3i(0)), hi = min(end - origin, Vec3i(kBrickEdge));
        for (int i = lo.x; i < hi.x; ++i) {
          for (int j = lo.y; j < hi.y; ++j) {
            const auto row = std::size_t((i * kBrickEdge + j) * kBrickEdge);
            std::fill_n(&brick.lo[row + std::size_t(lo.z)], hi.z - lo.z, node.lo);
            std::fill_n(&brick.hi[row + std::size_t(lo.z)], hi.z - lo.z, node.hi);
          }
        }
      }
    }
  }
}

VoxelGrid as_grid(const std::shared_ptr<const Bricks>& bricks, const char* name, const Affine& map,
                  std::array<float, kBrickSamples> BoundBrick::*values) {
  VoxelGrid g;
  g.name = name;
  g.index_to_world = map;
  for (const auto& [origin, brick] : *bricks) g.bricks.push_back({origin, (brick.*values).data()});
  g.owner = bricks;
  return g;
}

}  // namespace

BoundGrids make_bound_grids(const Pyramid& pyramid, const Affine& index_to_world,
                            std::uint64_t max_bricks) {
  const auto bricks = std::make_shared<Bricks>();
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    const auto& nodes = pyramid.levels[level];
    std::vector<char> divided(nodes.size(), 0);
    if (level > 0) {
      for (const PyramidNode& child : pyramid.levels[level - 1]) {
        if (const auto parent = find(nodes, child.code / 8)) divided[*parent] = 1;
      }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (divided[i]) continue;
      // The origin is a multiple of 8 cells: a whole number of leaves.
      const Vec3l at(pyramid.origin.x / kLeafEdge, pyramid.origin.y / kLeafEdge,
                     pyramid.origin.z / kLeafEdge);
      const Vec3i offset = Vec3i(morton_decode(nodes[i].code)) * (1 << level);
      fill(*bricks, Vec3i(at) + offset, 1 << level, nodes[i], max_bricks);
    }
  }
  const Vec3d edge{double(kLeafEdge)};
  const Affine map = index_to_world * translation(edge * 0.5) * scaling(edge);
  return {as_grid(bricks, "majorant", map, &BoundBrick::hi),
          as_grid(bricks, "minorant", map, &BoundBrick::lo)};
}

}  // namespace pvol
