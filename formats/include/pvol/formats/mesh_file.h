// Triangle meshes as other programs read them: Stanford PLY and Wavefront OBJ.
#pragma once

#include <filesystem>

#include "pvol/math/affine.h"
#include "pvol/math/triangle_mesh.h"

namespace pvol::formats {

/// The triangles of a .ply (text or binary, of either byte order) or .obj file, by its extension:
/// all its objects and groups as one mesh, in the order of the file. Only places and faces are
/// taken, not normals, colours or texture coordinates. A face of more corners becomes the fan of
/// one of its vertices, which is chosen so that convex faces and concave quadrilaterals are covered
/// exactly; other concave faces may be covered twice in places, so cut them up beforehand.
/// Triangles without area are kept: no ray meets them. Takes memory in proportion to the file's
/// bytes, whatever its header announces. Throws Error, which names file and line or byte, for other
/// extensions, a file that is damaged or cut off, vertices that are not finite, faces of vertices
/// that are not there, and a file without faces.
[[nodiscard]] TriangleMesh read_mesh(const std::filesystem::path& file);

/// Writes a mesh in world space: binary little-endian .ply with double coordinates, or .obj with as
/// many digits as a double needs, chosen by the file's extension. Triangles run counter-clockwise
/// as seen from outside also where the map mirrors. The same mesh gives the same bytes. Atomic.
/// Throws Error for other extensions, for a vertex that the map takes out of the range of finite
/// numbers and where writing fails.
void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh,
                const Affine& index_to_world);

}  // namespace pvol::formats
