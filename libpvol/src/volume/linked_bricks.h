// A volume made of bricks that are there: for another extinction or place, or after some of them
// changed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/field/shared_field.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// A field's bricks, which volumes share, and which of them each node of its pyramid has.
struct LinkedBricks {
  FieldValues values;  ///< no recipe
  std::vector<std::vector<std::uint32_t>> brick_of;
  BoundsExcess excess;
  std::shared_ptr<const SampleCodes> codes{};  ///< null: there are none
};
/// The copies of samples; they are not shared.
[[nodiscard]] inline const BrickField& copies_of(const LinkedBricks& bricks) {
  return *std::get<std::shared_ptr<const BrickField>>(bricks.values);
}

/// The links of a field that is a BrickField or a SharedField.
template <class Field>
[[nodiscard]] LinkedBricks link(WithLinks<Field>&& built) {
  return {std::make_shared<const Field>(std::move(built.field)), std::move(built.brick_of),
          built.excess, std::move(built.codes)};
}

/// Micro-bounds of such bricks.
[[nodiscard]] MicroBounds build_micro_bounds(const LinkedBricks& bricks, int edge);

/// Those of the bricks that a volume is made of, with this edge.
using GetMicroBounds = std::function<MicroBounds(int edge)>;

/// As make_volume of the grid and pyramid that the bricks were made of, with options without map
/// and homogenised parts.
[[nodiscard]] Volume make_volume(const LinkedBricks& bricks, const Pyramid& pyramid,
                                 const Affine& index_to_object, const Medium& medium,
                                 const VolumeOptions& options, const GetMicroBounds& micro_bounds);

}  // namespace pvol::detail
