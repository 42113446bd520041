// Where the volumes of a scene are: each once or many times, with its data in memory once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pvol/math/float4.h"
#include "pvol/volume/volume.h"
#include "render/scene/box_tree.h"

namespace pvol {
struct MovingPlace;  // volume/moving_places.h
}

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
    return widen(Vec3f(Vec3d(x.x, y.x, z.x))) * splat(d.x) +
           widen(Vec3f(Vec3d(x.y, y.y, z.y))) * splat(d.y) +
           widen(Vec3f(Vec3d(x.z, y.z, z.z))) * splat(d.z);
  }
};

/// What moves an instance.
struct InstanceMotion {
  const MovingPlace* place;  ///< of the volume's; null: it stands still
  Affine cells_to_object;
};

/// All places of all volumes.
struct Instances {
  std::vector<Instance> all;  ///< volume by volume; what moves, in the middle of the shutter
  BoxTree tree;               ///< of their numbers, around what moves at all times of the shutter
  std::vector<InstanceMotion> motion{};  ///< of all; empty where none moves

  /// The volumes outlive this.
  explicit Instances(std::span<const Volume> volumes);
  [[nodiscard]] std::size_t bytes() const {
    return all.capacity() * sizeof(Instance) + tree.bytes() +
           motion.capacity() * sizeof(InstanceMotion);
  }
  [[nodiscard]] bool moves() const { return !motion.empty(); }
  /// Whether there is one alone that stands still.
  [[nodiscard]] bool is_one_still() const { return all.size() == 1 && !moves(); }
  /// An instance at a time, in frames, while the shutter is open.
  [[nodiscard]] Instance at_time(std::uint32_t number, double frames) const;
  /// The same, which `moved` holds where any moves.
  [[nodiscard]] const Instance& at_time(std::uint32_t number, double frames,
                                        Instance& moved) const {
    return moves() ? moved = at_time(number, frames) : all[number];
  }

 private:
  void add_motion(std::span<const Volume> volumes);
};

}  // namespace pvol::detail
