#include "file/mesh_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>

#include "file/byte_source.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/mesh_file.h"

namespace pvol::formats {
namespace detail {
namespace {

/// Beyond, looking for a vertex whose fan fits would take the square of their number.
constexpr std::size_t kMostSearched = 64;

using Corners = std::span<const std::uint32_t>;

/// The face's normal, of any length, by Newell's sum over its edges.
Vec3d normal_of(const std::vector<Vec3d>& vertices, Corners face) {
  Vec3d sum{};
  const Vec3d origin = vertices[face[0]];  // far from 0, edges would drown in their places
  for (std::size_t i = 1; i + 1 < face.size(); ++i) {
    sum += cross(vertices[face[i]] - origin, vertices[face[i + 1]] - origin);
  }
  return sum;
}

bool fan_fits(const std::vector<Vec3d>& vertices, Corners face, std::size_t first, Vec3d normal) {
  const std::size_t n = face.size();
  const Vec3d hub = vertices[face[first]];
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vec3d a = vertices[face[(first + i) % n]], b = vertices[face[(first + i + 1) % n]];
    if (dot(cross(a - hub, b - hub), normal) < 0) return false;
  }
  return true;
}

std::size_t hub_of_fan(const std::vector<Vec3d>& vertices, Corners face) {
  if (face.size() == 3 || face.size() > kMostSearched) return 0;
  const Vec3d normal = normal_of(vertices, face);
  for (std::size_t first = 0; first < face.size(); ++first) {
    if (fan_fits(vertices, face, first, normal)) return first;
  }
  return 0;
}

}  // namespace

TriangleMesh to_triangles(PolygonMesh mesh) {
  TriangleMesh result;
  result.triangles.reserve(mesh.faces.corners.size() - 2 * mesh.faces.ends.size());
  std::size_t begin = 0;
  for (const std::size_t end : mesh.faces.ends) {
    const Corners face(mesh.faces.corners.data() + begin, end - begin);
    const std::size_t n = face.size(), hub = hub_of_fan(mesh.vertices, face);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      result.triangles.push_back({face[hub], face[(hub + i) % n], face[(hub + i + 1) % n]});
    }
    begin = end;
  }
  result.vertices = std::move(mesh.vertices);
  return result;
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 24;
  std::string result(text.substr(0, kMost));
  std::ranges::replace_if(
      result, [](char c) { return std::isprint(static_cast<unsigned char>(c)) == 0; }, '?');
  return text.size() > kMost ? result + "..." : result;
}

}  // namespace detail

TriangleMesh read_mesh(const std::filesystem::path& file) {
  refuse_folder(file, "a mesh (.obj or .ply)");
  const std::string extension = ending(file);
  if (extension != ".obj" && extension != ".ply") {
    throw Error(file.string() + ": meshes are read from .obj and .ply; convert the file to one");
  }
  detail::ByteSource source(file);
  std::string bytes(source.size(), '\0');
  source.copy(0, source.size(), bytes.data());
  detail::PolygonMesh mesh =
      extension == ".obj" ? detail::decode_obj(file, bytes) : detail::decode_ply(file, bytes);
  if (mesh.faces.ends.empty()) {
    throw Error(fmt::format("{}: has {} vertices and no face; expected at least one triangle",
                            file.string(), mesh.vertices.size()));
  }
  return detail::to_triangles(std::move(mesh));
}

}  // namespace pvol::formats
