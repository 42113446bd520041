// Meshes, .ply and .obj: what is read is written as .ply and read back the same.
#include "fuzz.h"
#include "pvol/formats/mesh_file.h"

namespace {

using namespace pvol::fuzz;

/// Whether the bytes begin as .ply files do; all others are tried as .obj.
bool is_ply(Input bytes) { return bytes.size() > 3 && bytes[0] == 'p' && bytes[1] == 'l'; }

void check(const pvol::TriangleMesh& mesh) {
  for (const auto& triangle : mesh.triangles) {
    for (const auto corner : triangle) {
      require(std::size_t(corner) < mesh.vertices.size(), "a face has a vertex that is not there");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Input bytes{data, size};
  pvol::TriangleMesh mesh;
  const auto file = scratch_file(is_ply(bytes) ? "mesh.ply" : "mesh.obj", bytes);
  if (!accepts([&] { mesh = pvol::formats::read_mesh(file); })) return 0;
  check(mesh);
  const auto again = scratch_file("again.ply", {});
  pvol::formats::write_mesh(again, mesh, pvol::Affine{});
  const pvol::TriangleMesh same = pvol::formats::read_mesh(again);
  require(same.vertices == mesh.vertices, "a mesh reads back with other vertices");
  require(same.triangles == mesh.triangles, "a mesh reads back with other triangles");
  return 0;
}
