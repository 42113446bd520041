// Triangles of a scene ready for rays: Embree finds them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "pvol/math/triangle_mesh.h"

namespace pvol::detail {

/// Some triangles and their place in the world.
struct PlacedMesh {
  const TriangleMesh* mesh;
  Affine to_world;
};

/// Immutable; safe to use from any thread. Embree computes in float: the triangles stand in a frame
/// around their middle in which they reach about as far as 1, rays are moved to their box in
/// double, and what is hit is computed again in double from the triangle as Embree has it.
class MeshScene {
 public:
  /// Of valid meshes; they need not outlive this. Throws Error where Embree fails, and for a mesh
  /// that its place takes out of the range of numbers.
  explicit MeshScene(std::span<const PlacedMesh> meshes);

  struct Hit {
    double t;
    Vec3d normal;  ///< of any length; 0 for a triangle without area
    /// Farther from the triangle's plane than what is computed of the place may be off, in world
    /// units: paths go on from so far before it.
    double clearance;
    std::uint32_t mesh;  ///< number
  };
  /// The first triangle that the ray, of unit direction, meets with t in (0, limit).
  [[nodiscard]] std::optional<Hit> first_hit(const Ray& ray, double limit) const;
  /// Whether there is one.
  [[nodiscard]] bool blocks(const Ray& ray, double limit) const;
  /// Whether the box around any triangle meets this one.
  [[nodiscard]] bool may_reach(const Box& box) const;
  /// How far a place is at least from all triangles, up to `most`: of each, how far it is from its
  /// plane or from the box around it.
  [[nodiscard]] double distance(Vec3d place, double most) const;

 private:
  struct Embree;
  struct Query;
  [[nodiscard]] std::optional<Query> query(const Ray& ray, double limit) const;

  std::shared_ptr<const Embree> embree_;
  Box box_;  ///< in the world, with a rim
  Vec3d centre_;
  double scale_ = 1;  ///< from the world to Embree's frame, a power of two
};

}  // namespace pvol::detail
