// Triangle meshes as other programs read them: Stanford PLY and Wavefront OBJ.
#pragma once

#include <filesystem>

#include "pvol/math/affine.h"
#include "pvol/shell/mesh.h"

namespace pvol::formats {

/// Writes a mesh in world space: binary little-endian .ply with double coordinates, or .obj with as
/// many digits as a double needs, chosen by the file's extension. Triangles run counter-clockwise
/// as seen from outside also where the map mirrors. The same mesh gives the same bytes. Atomic.
/// Throws Error for other extensions, for a vertex that the map takes out of the range of finite
/// numbers and where writing fails.
void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh,
                const Affine& index_to_world);

}  // namespace pvol::formats
