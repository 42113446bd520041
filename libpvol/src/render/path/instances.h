// Where the volumes of a scene are: each once or many times, with its data in memory once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pvol/math/lanes.h"
#include "pvol/volume/volume.h"
#include "render/path/box_tree.h"

namespace pvol::detail {

/// A volume at one of its places. What a flight needs besides follows from these in less time than
/// it takes to read: a thousand instances take 0.1 MB.
struct Instance {
  Affine world_to_cells;
  std::uint32_t volume;  ///< number
  std::uint32_t place;   ///< of the volume's; 0: the first

  /// A ray of the world in cells from the octree's origin; its t is world length still.
  [[nodiscard]] Ray in_cells(const Ray& ray) const {
    return {world_to_cells.point(ray.o), world_to_cells.vector(ray.d)};
  }
  [[nodiscard]] Float4 in_cells(Vec3f d) const {
    const auto& [x, y, z] = world_to_cells.m;
    return lanes(Vec3f(Vec3d(x.x, y.x, z.x))) * splat(d.x) +
           lanes(Vec3f(Vec3d(x.y, y.y, z.y))) * splat(d.y) +
           lanes(Vec3f(Vec3d(x.z, y.z, z.z))) * splat(d.z);
  }
};

/// A place in the world and what holds it.
struct WorldPlace {
  Vec3d position;
  const Instance* within = nullptr;  ///< that the path's last collision was in
};

/// All places of all volumes.
struct Instances {
  std::vector<Instance> all;  ///< volume by volume
  BoxTree tree;               ///< of their numbers

  explicit Instances(std::span<const Volume> volumes);
  [[nodiscard]] std::size_t bytes() const {
    return all.capacity() * sizeof(Instance) + tree.bytes();
  }
};

}  // namespace pvol::detail
