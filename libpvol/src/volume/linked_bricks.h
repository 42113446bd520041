// A volume made of bricks that are there: for another extinction or place, or after some of them
// changed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// A field's bricks, which volumes share, and which of them each node of its pyramid has.
struct LinkedBricks {
  std::shared_ptr<const BrickField> field;
  std::vector<std::vector<std::uint32_t>> brick_of;
  BoundsExcess excess;
};
[[nodiscard]] LinkedBricks link(FieldWithLinks&& built);

/// Micro-bounds of these bricks with this edge.
using GetMicroBounds = std::function<MicroBounds(const BrickField&, int edge)>;

/// As make_volume of the grid and pyramid that the bricks were made of, with options without map
/// and homogenised parts.
[[nodiscard]] Volume make_volume(const LinkedBricks& bricks, const Pyramid& pyramid,
                                 const Affine& index_to_object, const Medium& medium,
                                 const VolumeOptions& options, const GetMicroBounds& micro_bounds);

}  // namespace pvol::detail
