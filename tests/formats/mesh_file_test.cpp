#include "pvol/formats/mesh_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <sstream>

#include "pvol/error.h"
#include "pvol/shell/mesh.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace mesh_file_test {

TriangleMesh cube() { return make_mesh(make_support({{2, 3, 4}})); }

/// Turned, sheared, far away and small.
Affine placement() {
  Affine a;
  a.m = {Vec3d{0, -1e-3, 2e-4}, Vec3d{1e-3, 0, 0}, Vec3d{0, 0, 1e-3}};
  a.t = {1e8, -3.25, 1 / 3.0};
  return a;
}
Affine mirrored(Affine a) {
  for (Vec3d& row : a.m) row.x = -row.x;
  return a;
}

template <class T>
T take(const std::string& bytes, std::size_t& at) {
  T value{};
  EXPECT_LE(at + sizeof value, bytes.size());
  std::memcpy(&value, bytes.data() + at, sizeof value);
  at += sizeof value;
  return value;
}

/// A reader of what the header below announces, and of nothing else.
TriangleMesh read_ply(const std::string& bytes) {
  const std::string end = "end_header\n";
  std::size_t at = bytes.find(end) + end.size();
  const std::string header = bytes.substr(0, at);
  TriangleMesh mesh;
  unsigned vertices = 0, faces = 0;
  std::istringstream words(header);
  for (std::string word; words >> word;) {
    if (word == "vertex") words >> vertices;
    if (word == "face") words >> faces;
  }
  EXPECT_EQ(header,
            "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertices) +
                "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                std::to_string(faces) + "\nproperty list uchar uint vertex_indices\nend_header\n");
  for (unsigned i = 0; i < vertices; ++i) {
    const double x = take<double>(bytes, at), y = take<double>(bytes, at);
    mesh.vertices.push_back({x, y, take<double>(bytes, at)});
  }
  for (unsigned i = 0; i < faces; ++i) {
    EXPECT_EQ(take<std::uint8_t>(bytes, at), 3);
    const auto a = take<std::uint32_t>(bytes, at), b = take<std::uint32_t>(bytes, at);
    mesh.triangles.push_back({a, b, take<std::uint32_t>(bytes, at)});
  }
  EXPECT_EQ(at, bytes.size());
  return mesh;
}

TriangleMesh read_obj(const std::string& text) {
  TriangleMesh mesh;
  std::istringstream lines(text);
  for (std::string kind; lines >> kind;) {
    if (kind == "v") {
      std::string x, y, z;  // a stream's own reading of numbers rounds differently on some systems
      lines >> x >> y >> z;
      mesh.vertices.push_back({std::stod(x), std::stod(y), std::stod(z)});
    } else {
      EXPECT_EQ(kind, "f");
      std::array<std::uint32_t, 3> t{};
      for (std::uint32_t& i : t) lines >> i, --i;
      mesh.triangles.push_back(t);
    }
  }
  return mesh;
}

TriangleMesh round_trip(const std::string& name, const TriangleMesh& mesh, const Affine& map) {
  const TemporaryFolder folder;
  write_mesh(folder.file(name), mesh, map);
  const std::string bytes = read_bytes(folder.file(name));
  return name.ends_with(".ply") ? read_ply(bytes) : read_obj(bytes);
}

TEST(MeshFile, HoldsEachVertexToTheLastBitAndEachTriangle) {
  const TriangleMesh mesh = cube();
  for (const std::string name : {"a.ply", "a.obj"}) {
    const TriangleMesh read = round_trip(name, mesh, placement());
    ASSERT_EQ(read.vertices.size(), mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      EXPECT_EQ(read.vertices[i], placement().point(mesh.vertices[i]));
    }
    EXPECT_EQ(read.triangles, mesh.triangles);
  }
}

TEST(MeshFile, NormalsPointOutwardAlsoThroughMirrors) {
  Affine small = placement();
  small.t = {};  // so that the volume of so small a cube has digits
  for (const std::string name : {"a.ply", "a.obj"}) {
    EXPECT_NEAR(volume(round_trip(name, cube(), small)), 1e-9, 1e-18);
    EXPECT_NEAR(volume(round_trip(name, cube(), mirrored(small))), 1e-9, 1e-18);
  }
}

TEST(MeshFile, RefusesOtherNamesAndPlacesBeyondNumbers) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_mesh(folder.file("a.stl"), cube(), {}), Error);
  Affine huge;
  huge.t.x = std::numeric_limits<double>::infinity();
  EXPECT_THROW(write_mesh(folder.file("a.ply"), cube(), huge), Error);
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.ply")));
}

TEST(MeshFile, EmptyMeshIsAValidFile) {
  EXPECT_TRUE(round_trip("a.ply", {}, {}).triangles.empty());
  EXPECT_TRUE(round_trip("a.obj", {}, {}).triangles.empty());
}

}  // namespace mesh_file_test
}  // namespace pvol::formats
