#include "pvol/formats/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <fstream>
#include <string>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"

namespace pvol::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

/// The mesh seen from the world; a mirroring map turns every triangle round.
TriangleMesh to_world(const std::filesystem::path& file, TriangleMesh mesh, const Affine& map) {
  for (Vec3d& v : mesh.vertices) {
    v = map.point(v);
    if (!is_finite(v)) {
      throw Error(file.string() +
                  ": a vertex of the mesh is not finite in world space; check the transform");
    }
  }
  if (determinant(map) < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// PLY as in Turk. The PLY Polygon File Format. 1994.
std::string encode_ply(const TriangleMesh& mesh) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
  bytes += fmt::format("element vertex {}\n", mesh.vertices.size());
  bytes += "property double x\nproperty double y\nproperty double z\n";
  bytes += fmt::format("element face {}\n", mesh.triangles.size());
  bytes += "property list uchar uint vertex_indices\nend_header\n";
  bytes.reserve(bytes.size() + 24 * mesh.vertices.size() + 13 * mesh.triangles.size());
  for (const Vec3d v : mesh.vertices) append(bytes, v.x), append(bytes, v.y), append(bytes, v.z);
  for (const auto& t : mesh.triangles) {
    append(bytes, std::uint8_t{3});
    for (const std::uint32_t i : t) append(bytes, i);
  }
  return bytes;
}

template <class T>
void append_text(std::string& text, T value) {
  char digits[32];
  text += ' ';
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

std::string encode_obj(const TriangleMesh& mesh) {
  std::string text;
  for (const Vec3d v : mesh.vertices) {
    text += 'v';
    for (int axis = 0; axis < 3; ++axis) append_text(text, v[axis]);
    text += '\n';
  }
  for (const auto& t : mesh.triangles) {
    text += 'f';
    for (const std::uint32_t i : t) append_text(text, std::uint64_t{i} + 1);
    text += '\n';
  }
  return text;
}

std::string encode(const std::filesystem::path& file, const TriangleMesh& mesh) {
  const std::string extension = ending(file);
  if (extension == ".ply") return encode_ply(mesh);
  if (extension == ".obj") return encode_obj(mesh);
  throw Error(file.string() +
              ": meshes are written as .ply or .obj; choose a name with one of these endings");
}

}  // namespace

void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh,
                const Affine& index_to_world) {
  const std::string bytes = encode(file, to_world(file, mesh, index_to_world));
  write_atomically(file, [&](const std::filesystem::path& aside) {
    std::ofstream stream(aside, std::ios::binary);
    stream.write(bytes.data(), std::streamsize(bytes.size()));
    stream.close();
    if (!stream)
      throw Error(file.string() + ": cannot be written; check that there is space on the disk");
  });
}

}  // namespace pvol::formats
