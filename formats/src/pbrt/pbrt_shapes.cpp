#include "pbrt/pbrt_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "file/mesh_read.h"

namespace pvol::formats::detail {
namespace {

constexpr int kAround = 96, kAlong = 48;  // steps of round shapes

/// Groups of as many vertices as a face has.
std::vector<std::uint32_t> indices_of(const PbrtShape& shape, std::size_t vertices,
                                      std::size_t corners) {
  std::vector<std::uint32_t> all;
  const std::vector<double> given = shape.parameters.numbers("indices");
  if (given.empty() && vertices == corners) {
    for (std::uint32_t i = 0; i < corners; ++i) all.push_back(i);
  }
  for (const double i : given) {
    if (!(i >= 0 && i < double(vertices) && i == std::floor(i))) {
      fail_at(shape.where, fmt::format("index {} of {} vertices", i, vertices), "a smaller number");
    }
    all.push_back(std::uint32_t(i));
  }
  if (all.empty() || all.size() % corners != 0) {
    fail_at(shape.where, fmt::format("{} indices of a {}", all.size(), shown(shape.type)),
            fmt::format("{} for each face", corners));
  }
  return all;
}

TriangleMesh triangle_mesh(const PbrtShape& shape) {
  TriangleMesh mesh{shape.parameters.points("P"), {}};
  const auto n = indices_of(shape, mesh.vertices.size(), 3);
  for (std::size_t i = 0; i < n.size(); i += 3)
    mesh.triangles.push_back({n[i], n[i + 1], n[i + 2]});
  return mesh;
}

/// The corners of a patch are those of its lower side, then those of its upper one.
TriangleMesh bilinear_mesh(const PbrtShape& shape, ImportNotes& notes) {
  TriangleMesh mesh{shape.parameters.points("P"), {}};
  const auto n = indices_of(shape, mesh.vertices.size(), 4);
  bool bent = false;
  for (std::size_t i = 0; i < n.size(); i += 4) {
    const auto at = [&](std::size_t c) { return mesh.vertices[n[i + c]] - mesh.vertices[n[i]]; };
    const double size = std::max({length(at(1)), length(at(2)), length(at(3))});
    bent = bent || std::abs(dot(cross(at(1), at(2)), at(3))) > 1e-6 * size * size * size;
    mesh.triangles.push_back({n[i], n[i + 1], n[i + 3]});
    mesh.triangles.push_back({n[i], n[i + 3], n[i + 2]});
  }
  if (bent) notes.add(shape.where, "bilinear patches that are not flat become two triangles each");
  return mesh;
}

/// A sheet of steps in two directions.
TriangleMesh sheet(int across, int up, const std::function<Vec3d(double, double)>& point) {
  TriangleMesh mesh;
  for (int j = 0; j <= up; ++j) {
    for (int i = 0; i <= across; ++i) {
      mesh.vertices.push_back(point(double(i) / across, double(j) / up));
    }
  }
  for (int j = 0; j < up; ++j) {
    for (int i = 0; i < across; ++i) {
      const auto a = std::uint32_t(j * (across + 1) + i), b = a + std::uint32_t(across) + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

/// Round shapes about z, by an angle and a second parameter, both over [0, 1].
TriangleMesh round_shape(const PbrtShape& shape) {
  const PbrtParameters& p = shape.parameters;
  const double r = p.number("radius", 1);
  const double most = std::clamp(p.number("phimax", 360), 0.0, 360.0) * (std::numbers::pi / 180);
  const auto ring = [&](double u, double radius, double z) {
    return Vec3d{radius * std::cos(u * most), radius * std::sin(u * most), z};
  };
  if (shape.type == "disk") {
    const double inner = p.number("innerradius", 0), z = p.number("height", 0);
    return sheet(kAround, 1,
                 [=](double u, double v) { return ring(u, inner + v * (r - inner), z); });
  }
  const double lo = p.number("zmin", -(shape.type == "sphere" ? r : 1));
  const double hi = p.number("zmax", shape.type == "sphere" ? r : 1);
  if (shape.type == "cylinder") {
    return sheet(kAround, 1, [=](double u, double v) { return ring(u, r, lo + v * (hi - lo)); });
  }
  const double from = std::acos(std::clamp(lo / r, -1.0, 1.0));
  const double to = std::acos(std::clamp(hi / r, -1.0, 1.0));
  return sheet(kAround, kAlong, [=](double u, double v) {
    const double angle = from + v * (to - from);
    return ring(u, r * std::sin(angle), r * std::cos(angle));
  });
}

}  // namespace

TriangleMesh triangles_of(const PbrtShape& shape, ImportNotes& notes) {
  for (const char* name : {"N", "uv", "S", "faceIndices"}) (void)shape.parameters.find(name);
  if (shape.type == "trianglemesh") return triangle_mesh(shape);
  if (shape.type == "bilinearmesh") return bilinear_mesh(shape, notes);
  if (shape.type == "sphere" || shape.type == "disk" || shape.type == "cylinder") {
    if (!(shape.parameters.number("radius", 1) > 0)) {
      fail_at(shape.where, "a radius of 0 or less", "a radius above 0");
    }
    notes.add(shape.where,
              fmt::format("shapes of type {} become triangles of 3.75 degrees{}", shape.type,
                          shape.type == "sphere" ? " where they are cut or stretched" : ""));
    return round_shape(shape);
  }
  notes.add(shape.where, fmt::format("shapes of type \"{}\" are left out", shown(shape.type)));
  return {};
}

}  // namespace pvol::formats::detail
