// Triangle meshes for tests.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "pvol/math/triangle_mesh.h"
#include "pvol/render/surface.h"

namespace pvol::test {

/// A closed unit ball, `rings` triangles high and twice as many around: its triangles lie inside by
/// up to 5 / rings^2.
[[nodiscard]] inline TriangleMesh ball_mesh(int rings) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(2 * rings);
  for (int y = 1; y < rings; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const double theta = std::numbers::pi * y / rings, phi = 2 * std::numbers::pi * x / n;
      mesh.vertices.push_back(
          {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)});
    }
  }
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size()), bottom = top + 1;
  mesh.vertices.push_back({0, 1, 0});
  mesh.vertices.push_back({0, -1, 0});
  const auto last = static_cast<std::uint32_t>(rings - 2) * n;
  for (std::uint32_t x = 0; x < n; ++x) {
    const std::uint32_t next = (x + 1) % n;
    mesh.triangles.push_back({top, next, x});
    mesh.triangles.push_back({bottom, last + x, last + next});
    for (std::uint32_t row = 0; row < last; row += n) {
      mesh.triangles.push_back({row + x, row + next, row + n + x});
      mesh.triangles.push_back({row + next, row + n + next, row + n + x});
    }
  }
  return mesh;
}

/// A square of this half edge about the origin, facing +y.
[[nodiscard]] inline TriangleMesh square_mesh(double half) {
  return {{{-half, 0, -half}, {-half, 0, half}, {half, 0, half}, {half, 0, -half}},
          {{0, 1, 2}, {0, 2, 3}}};
}

/// A mesh as a surface, at a place.
[[nodiscard]] inline MeshSurface mesh_surface(TriangleMesh mesh, const Affine& place = {}) {
  MeshSurface m;
  m.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  m.place.matrix = place;
  return m;
}

}  // namespace pvol::test
