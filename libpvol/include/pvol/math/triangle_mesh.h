// Triangles that share vertices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol {

/// Each triangle has the numbers of its three vertices; its front is where they run
/// counter-clockwise.
struct TriangleMesh {
  std::vector<Vec3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  friend bool operator==(const TriangleMesh&, const TriangleMesh&) = default;
};

}  // namespace pvol
