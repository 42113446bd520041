#include "usda/usda_mesh.h"

#include <fmt/format.h>

#include <cmath>

#include "file/mesh_read.h"

namespace pvol::formats::detail {
namespace {

/// A whole number below `limit`.
std::uint32_t whole_below(double number, double limit, const UsdAttribute& of,
                          const std::string& what) {
  if (number >= 0 && number < limit && number == std::floor(number)) return std::uint32_t(number);
  fail_at(of.where, fmt::format("{} {}", what, number),
          fmt::format("a whole number from 0 to {}", limit - 1));
}

PolygonMesh polygons_of(const UsdView& mesh) {
  PolygonMesh all;
  all.vertices = mesh.vectors("points");
  const std::vector<double> counts = mesh.numbers("faceVertexCounts");
  const std::vector<double> indices = mesh.numbers("faceVertexIndices");
  std::size_t end = 0;
  for (const double count : counts) {
    const UsdAttribute& of = *mesh.find("faceVertexCounts");
    const std::size_t begin = end;
    end += whole_below(count, double(indices.size() - begin) + 1, of, "a face with corners");
    if (end - begin < 3) continue;  // without an area
    for (std::size_t i = begin; i < end; ++i) {
      all.faces.corners.push_back(whole_below(indices[i], double(all.vertices.size()),
                                              *mesh.find("faceVertexIndices"), "index"));
    }
    all.faces.ends.push_back(all.faces.corners.size());
  }
  return all;
}

/// A rectangle about the origin across an axis.
PolygonMesh plane_of(const UsdView& plane) {
  const double width = plane.number("width", 2) / 2, length = plane.number("length", 2) / 2;
  const std::string axis = plane.word("axis", "Z");
  PolygonMesh all;
  for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const double x = a * width, y = b * length;
    all.vertices.push_back(axis == "X"   ? Vec3d{0, y, x}
                           : axis == "Y" ? Vec3d{x, 0, y}
                                         : Vec3d{x, y, 0});
  }
  all.faces = {{0, 1, 2, 3}, {4}};
  return all;
}

PolygonMesh cube_of(const UsdView& cube) {
  const double half = cube.number("size", 2) / 2;
  PolygonMesh all;
  for (int i = 0; i < 8; ++i) {
    all.vertices.push_back(Vec3d((i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2) * 2 - 1) * half);
  }
  all.faces = {{0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5},
               {4, 8, 12, 16, 20, 24}};
  return all;
}

}  // namespace

TriangleMesh triangles_of(const UsdView& shape, const UsdMaking& making) {
  if (shape.prim().type == "Plane") return to_triangles(plane_of(shape));
  if (shape.prim().type == "Cube") return to_triangles(cube_of(shape));
  if (shape.word("subdivisionScheme", "catmullClark") != "none") {
    making.note(shape.where(), "meshes are taken as they are, without subdivision");
  }
  return to_triangles(polygons_of(shape));
}

}  // namespace pvol::formats::detail
