// Reading single grids through OpenVDB, for sources that see it anyway.
#pragma once

#include <openvdb/openvdb.h>

#include "pvol/math/affine.h"
#include "vdb/vdb_inspect.h"

namespace pvol::formats::detail {

/// An inspected grid, whose tree may be another's. Throws Error where it is damaged.
[[nodiscard]] openvdb::GridBase::Ptr load_vdb_grid(ByteSource& source, const VdbFile& file,
                                                   const VdbGrid& grid);

/// Its map to the world. OpenVDB's maps act on row vectors; asking where the axes go hides that.
/// Throws Error for one without an inverse.
[[nodiscard]] Affine affine_map(const ByteSource& source, const VdbGrid& grid,
                                const openvdb::math::Transform& transform);

}  // namespace pvol::formats::detail
