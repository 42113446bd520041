// Triangles of several meshes in one.
#pragma once

#include <cstdint>

#include "pvol/math/affine.h"
#include "pvol/math/triangle_mesh.h"

namespace pvol::formats::detail {

/// Adds a mesh, whose vertices `place` moves.
inline void append(TriangleMesh& to, const TriangleMesh& mesh, const Affine& place) {
  const auto first = std::uint32_t(to.vertices.size());
  for (const Vec3d v : mesh.vertices) to.vertices.push_back(place.point(v));
  for (const auto& t : mesh.triangles) {
    to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

}  // namespace pvol::formats::detail
