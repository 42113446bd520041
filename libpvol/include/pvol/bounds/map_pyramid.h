// Bounds of a field whose values are mapped.
#pragma once

#include "pvol/bounds/pyramid.h"
#include "pvol/math/field_map.h"

namespace pvol {

/// Bounds of map(v) where the pyramid bounds v: by the exact range of the map over the range of
/// each leaf and uniform cube, so that they stay as tight as they were (THEORY.md, T1.5). Cubes in
/// which the map is 0 throughout are left out, and the support shrinks to those that stay. Bounds
/// are no codes of .pvol files any more: the result is for walks, not for files. Throws Error for a
/// map of 0 to something else, which would fill all space, and for one beyond single precision.
[[nodiscard]] Pyramid map_pyramid(const Pyramid& pyramid, const FieldMap& map);

/// What belongs to nodes of a pyramid, by level and node, for those of the mapped one that are
/// leaves or uniform cubes; 0 for others.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> links_of(
    const Pyramid& mapped, const Pyramid& pyramid,
    const std::vector<std::vector<std::uint32_t>>& links);

}  // namespace pvol
