// Readers of single mesh formats, and what they share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pvol/math/triangle_mesh.h"

namespace pvol::formats::detail {

/// Faces with any number of corners, as files have them. Each corner is the number of a vertex.
struct Polygons {
  std::vector<std::uint32_t> corners;
  std::vector<std::size_t> ends;  ///< of each face, in `corners`
};

/// Vertices and faces of a file. The readers promise that vertices are finite and that faces have
/// at least three corners, all of which are there.
struct PolygonMesh {
  std::vector<Vec3d> vertices;
  Polygons faces;
};

/// Each face as the fan of one of its vertices: of the first from which all triangles face the way
/// of the face, where there is one, so that convex faces and concave quadrilaterals are covered
/// exactly; else, and with more than 64 corners, of its first.
[[nodiscard]] TriangleMesh to_triangles(PolygonMesh mesh);

/// Most vertices that a mesh may have.
inline constexpr std::uint64_t kMostVertices = 0xffff'ffff;

/// What a file says, for messages: at most 24 characters of it, without those that a terminal might
/// take for orders.
[[nodiscard]] std::string shown(std::string_view text);

// Both throw Error, which names file and place, for whatever is not as the format has it.
[[nodiscard]] PolygonMesh decode_obj(const std::filesystem::path& file, std::string_view text);
[[nodiscard]] PolygonMesh decode_ply(const std::filesystem::path& file, std::string_view bytes);

}  // namespace pvol::formats::detail
