#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>

#include "pvol/formats/mesh_file.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace mesh_read_test {

using test::error_of;

TriangleMesh read_text(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  write_bytes(folder.file(name), bytes);
  return read_mesh(folder.file(name));
}
std::string fault_of(const std::string& name, const std::string& bytes) {
  return error_of([&] { (void)read_text(name, bytes); });
}

/// A pyramid on a square: five vertices, one quadrilateral, four triangles.
const std::vector<Vec3d> kPyramid{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
const std::vector<std::vector<int>> kFaces{
    {0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
const TriangleMesh kExpected{kPyramid,
                             {{0, 3, 2}, {0, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};

template <class T>
void append(std::string& bytes, T value, bool big) {
  char b[sizeof value];
  std::memcpy(b, &value, sizeof value);
  if (big) std::reverse(b, b + sizeof value);
  bytes.append(b, sizeof value);
}

/// The pyramid in bytes, with properties between those that are wanted.
template <class Place, class Count, class Index>
std::string binary_ply(bool big, const std::string& place, const std::string& list) {
  std::string b = std::string("ply\r\nformat binary_") + (big ? "big" : "little") +
                  "_endian 1.0\r\ncomment made by hand\r\nobj_info x\r\nelement vertex 5\r\n" +
                  "property uchar red\r\nproperty " + place + " z\r\nproperty " + place +
                  " y\r\nproperty list ushort double weights\r\nproperty " + place +
                  " x\r\nelement range 2\r\nproperty list uchar short cells\r\nproperty int id\r\n"
                  "element face 5\r\nproperty float area\r\nproperty list " +
                  list + "\r\nproperty list char uchar flags\r\nend_header\r\n";
  for (const Vec3d v : kPyramid) {
    append(b, std::uint8_t(10), big);
    append(b, Place(v.z), big), append(b, Place(v.y), big);
    append(b, std::uint16_t(2), big), append(b, 7.0, big), append(b, 8.0, big);
    append(b, Place(v.x), big);
  }
  for (const std::uint8_t n : {std::uint8_t(0), std::uint8_t(3)}) {
    append(b, n, big);
    for (int i = 0; i < n; ++i) append(b, std::int16_t(-i), big);
    append(b, std::int32_t(4), big);
  }
  for (const auto& face : kFaces) {
    append(b, 1.5f, big), append(b, static_cast<Count>(face.size()), big);
    for (const int i : face) append(b, static_cast<Index>(i), big);
    append(b, std::int8_t(1), big), append(b, std::uint8_t(0xff), big);
  }
  return b;
}

const std::string kTextHeader =
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float64 x\nproperty float64 y\n"
    "property float64 z\nelement face 5\nproperty list uint8 int32 vertex_index\nend_header\n";
const std::string kTextPly =
    kTextHeader +
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n.5 5e-1 +1\n4 0 3 2 1\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4";

const std::string kObj =
    "# a pyramid\r\nmtllib a.mtl\no base\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 .1 .2 .3\n  v\t0 1 0\n"
    "f 1 4 3 2 # the base\nvn 0 0 1\nvt 0 0\n\ng sides\ns off\nusemtl stone\n"
    "v 5e-1 .5 \\\n  +1\nf 1/1 2/1 5/1\nf 2/1/1 3/1/1 5/1/1\nf 3//1 \\\r\n4//1 5//1\n"
    "f -2 -5 -1";

TEST(MeshRead, EveryVariantOfPlyIsTheSameMesh) {
  EXPECT_EQ(read_text("a.ply", kTextPly), kExpected);
  EXPECT_EQ(read_text("A.PLY", kTextPly + "\n\n"), kExpected);
  for (const bool big : {false, true}) {
    EXPECT_EQ(read_text("a.ply", binary_ply<float, std::uint8_t, std::int32_t>(
                                     big, "float", "uchar int vertex_indices")),
              kExpected);
    EXPECT_EQ(read_text("a.ply", binary_ply<double, std::uint32_t, std::uint16_t>(
                                     big, "double", "uint ushort vertex_index")),
              kExpected);
    EXPECT_EQ(read_text("a.ply", binary_ply<double, std::int16_t, std::int8_t>(
                                     big, "float64", "int16 int8 vertex_index")),
              kExpected);
  }
}

TEST(MeshRead, PlyOfIntegersAndOfFacesFirst) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list int uint vertex_indices\n"
      "element vertex 3\nproperty char x\nproperty short z\nproperty int y\nend_header\n"
      "3 2 1 0\n-128 -32768 5\n1 2 3\n4 5 6\n";
  const TriangleMesh mesh = read_text("a.ply", text);
  EXPECT_EQ(mesh.vertices[0], Vec3d(-128, 5, -32768));
  EXPECT_EQ(mesh.triangles, (decltype(mesh.triangles){{2, 1, 0}}));
}

TEST(MeshRead, BinaryPlyOfIntegersBelowZero) {
  for (const bool big : {false, true}) {
    std::string b = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\nelement vertex 3\nproperty char x\nproperty short y\n"
                    "property int z\nelement face 1\n"
                    "property list uchar uchar vertex_indices\nend_header\n";
    for (int i = 0; i < 3; ++i) {
      append(b, std::int8_t(-128 + i), big), append(b, std::int16_t(-32768 + i), big);
      append(b, std::int32_t(-70'000 - i), big);
    }
    for (const int v : {3, 0, 1, 2}) append(b, std::uint8_t(v), big);
    const TriangleMesh mesh = read_text("a.ply", b);
    EXPECT_EQ(mesh.vertices,
              (std::vector<Vec3d>{
                  {-128, -32768, -70'000}, {-127, -32767, -70'001}, {-126, -32766, -70'002}}));
  }
}

TEST(MeshRead, EveryStatementOfObj) { EXPECT_EQ(read_text("a.obj", kObj), kExpected); }

TEST(MeshRead, WhatWasWrittenComesBackToTheLastBit) {
  TriangleMesh mesh = kExpected;
  mesh.vertices[4] = {1e8 + 1 / 3.0, -1e-300, 0.1};
  const TemporaryFolder folder;
  for (const char* name : {"a.ply", "a.obj"}) {
    write_mesh(folder.file(name), mesh, {});
    EXPECT_EQ(read_mesh(folder.file(name)), mesh) << name;
  }
}

/// Of the triangles in the plane z = 0, each by its absolute value.
double covered(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    sum += std::abs(cross(b - a, c - a).z) / 2;
  }
  return sum;
}

TEST(MeshRead, FansCoverConvexAndOnceDentedFacesExactly) {
  const std::string dart = "v 0 0 0\nv 4 4 0\nv 0 1 0\nv -4 4 0\n";  // dented at the third
  for (const char* face : {"f 1 2 3 4", "f 2 3 4 1", "f 3 4 1 2", "f 4 1 2 3", "f 4 3 2 1"}) {
    const TriangleMesh mesh = read_text("a.obj", dart + face);
    EXPECT_EQ(mesh.triangles.size(), 2u);
    EXPECT_DOUBLE_EQ(covered(mesh), 4) << face;
  }
  const TriangleMesh pentagon = read_text(
      "a.obj",
      "v 1e8 0 0\nv 100000002 0 0\nv 100000002 2 0\nv 100000001 1 0\nv 1e8 2 0\nf 1 2 3 4 5");
  EXPECT_DOUBLE_EQ(covered(pentagon), 3);
}

TEST(MeshRead, AFaceOfVeryManyCornersTakesNoTime) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int i = 0; i < 300'000; ++i) text += i % 3 == 0 ? " 1" : i % 3 == 1 ? " 2" : " 3";
  EXPECT_EQ(read_text("a.obj", text).triangles.size(), 299'998u);
}

/// A fault and the key of its message.
struct Fault {
  std::string bytes, key;
};
void expect_faults(const std::string& name, const std::vector<Fault>& faults) {
  for (const auto& [bytes, key] : faults) EXPECT_TRUE(says(fault_of(name, bytes), key)) << bytes;
}

TEST(MeshRead, ObjErrorsNameTheLine) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  expect_faults("a.obj", {{"v 0 0\n", "mesh.numbers_after_v"},
                          {"v 0 0 0\nv 0 zero 0\n", "mesh.zero_finite_number"},
                          {"v 0 0 nan\n", "mesh.nan_finite_number"},
                          {"v 0 0 1e999\n", "mesh.number_overflow"},
                          {v + "f 1 2\n", "mesh.face_vertices"},
                          {v + "f 1 2 4\nf 1 2 3", "mesh.vertex_most_number"},
                          {v + "f 1 2 \\\n 3\n\nf 1 2 9", "mesh.vertex_most_number_vertices"},
                          {v + "f 0 1 2\n", "mesh.vertex_face"},
                          {v + "f -4 1 2\n", "mesh.vertex_minus_face"},
                          {v + "f 1 2 99999999999999999999\n", "mesh.corner_overflow"},
                          {v + "f 1 2 5000000000\n", "mesh.vertex_5000000000_face"},
                          {v + "f 1 2 3/x\n", "mesh.x_face"},
                          {v + "q 1 2 3\n", "mesh.q_statement_wavefront"},
                          {v + "surf 0 1 0 1 1 2\n", "mesh.free_form_surface"},
                          {v, "mesh.no_face"},
                          {"", "mesh.nothing"}});
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(MeshRead, PlyErrorsNameLineOrByte) {
  const std::string b =
      binary_ply<float, std::uint8_t, std::int32_t>(false, "float", "uchar int vertex_indices");
  expect_faults(
      "a.ply",
      {{"", "mesh.nothing_ply_first"},
       {"PLY\n", "mesh.ply_ply_first"},
       {replaced(kTextPly, "ascii", "text"), "mesh.format_text"},
       {replaced(kTextPly, "vertex 5", "vertex -5"), "mesh.element_vertex_minus"},
       {replaced(kTextPly, "float64 x", "real x"), "mesh.property_real_x"},
       {replaced(kTextPly, "uint8", "float"), "mesh.property_list_float"},
       {replaced(kTextPly, "float64 y", "float64 x"), "mesh.property_float64_x"},
       {replaced(kTextPly, "end_header\n", ""), "mesh.no_end_of_header"},
       {replaced(kTextPly, "element face", "element tristrips"), "mesh.no_element_face"},
       {replaced(kTextPly, "vertex_index", "corners"), "mesh.faces_without_vertices"},
       {replaced(kTextPly, "float64 z", "float64 depth"), "mesh.vertices_without_z"},
       {replaced(kTextPly, "1 1 0", "1 one 0"), "mesh.not_a_number"},
       {replaced(kTextPly, "1 1 0", "1 inf 0"), "mesh.infinite_coordinate"},
       {replaced(kTextPly, "3 0 1 4", "3 0 1 5"), "mesh.number_vertex"},
       {replaced(kTextPly, "3 0 1 4", "3 0 1 -1"), "mesh.number_vertex_minus"},
       {replaced(kTextPly, "3 0 1 4", "2 0 1 4"), "mesh.vertices_least_three"},
       {replaced(kTextPly, "3 0 1 4", "3.5 0 1 4"), "mesh.list"},
       {replaced(kTextPly, "vertex 5", "vertex 4000000000"), "mesh.vertices_of_text_cut_off"},
       {replaced(kTextPly, "vertex 5", "vertex 9000000000000000000"), "mesh.vertices_overflow"},
       {replaced(kTextPly, "face 5", "face 4000000000"), "mesh.faces_of_text_cut_off"},
       {replaced(kTextPly, "4 0 3", "4294967295 0 3"), "mesh.list_too_long"},
       {replaced(b, "vertex 5", "vertex 4000000000"), "mesh.vertices_cut_off"},
       {replaced(b, "face 5", "face 4000000000"), "mesh.faces_cut_off"},
       {replaced(b, "range 2", "range 9000000000000000000"), "mesh.elements_cut_off"},
       {b.substr(0, b.size() - 1), "mesh.face_cut_off"}});
}

TEST(MeshRead, RefusesOtherEndingsAndWhatIsNoFile) {
  EXPECT_TRUE(says(fault_of("a.stl", "solid"), "mesh.meshes_read_obj"));
  EXPECT_TRUE(
      says(error_of([] { (void)read_mesh("/nonexistent.ply"); }), "mesh.open_nonexistent_ply"));
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("d.ply"));
  EXPECT_NE(error_of([&] { (void)read_mesh(folder.file("d.ply")); }), "");
}

/// Either an Error or a mesh that keeps what `read_mesh` promises.
void expect_sound(const std::filesystem::path& file, const std::string& bytes) {
  write_bytes(file, bytes);
  TriangleMesh mesh;
  const std::string message = error_of([&] { mesh = read_mesh(file); });
  if (!message.empty()) {
    EXPECT_NE(message.find(file.filename().string()), message.npos) << message;
    return;
  }
  EXPECT_FALSE(mesh.triangles.empty());
  EXPECT_TRUE(std::ranges::all_of(mesh.vertices, [](Vec3d v) { return is_finite(v); }));
  for (const auto& t : mesh.triangles) {
    EXPECT_TRUE(std::ranges::all_of(t, [&](auto i) { return i < mesh.vertices.size(); }));
  }
}

TEST(MeshRead, EveryTruncationAndFlipIsAnErrorOrASoundMesh) {
  const TemporaryFolder folder;
  const std::pair<const char*, std::string> files[] = {
      {"a.obj", kObj},
      {"t.ply", kTextPly},
      {"b.ply",
       binary_ply<float, std::uint8_t, std::int32_t>(true, "float", "uchar int vertex_indices")},
      {"l.ply", binary_ply<double, std::uint32_t, std::uint16_t>(false, "double",
                                                                 "uint ushort vertex_index")}};
  for (const auto& [name, bytes] : files) {
    for (std::size_t n = 0; n < bytes.size(); ++n)
      expect_sound(folder.file(name), bytes.substr(0, n));
    for (std::size_t n = 0; n < bytes.size(); ++n) {
      for (const int flip : {1, 2, 0x10, 0x40, 0x80, 0xff}) {
        std::string damaged = bytes;
        damaged[n] = char(damaged[n] ^ flip);
        expect_sound(folder.file(name), damaged);
      }
    }
  }
}

TEST(MeshRead, ATruncatedFileOfBytesIsAlwaysAnError) {
  const std::string b =
      binary_ply<float, std::uint8_t, std::int32_t>(false, "float", "uchar int vertex_indices");
  for (std::size_t n = 0; n < b.size(); ++n) EXPECT_NE(fault_of("a.ply", b.substr(0, n)), "") << n;
}

}  // namespace mesh_read_test
}  // namespace pvol::formats
