// The samples of a brick, wherever a field has them.
#pragma once

#include "pvol/field/brick_field.h"
#include "pvol/field/shared_field.h"

namespace pvol::detail {

/// The 9^3 samples of brick b, in the order of BrickField; `scratch` has room for as many, which
/// are written there if need be.
[[nodiscard]] inline const float* samples_of(const BrickField& field, std::uint32_t b, float*) {
  return field.brick(b);
}
[[nodiscard]] const float* samples_of(const SharedField& field, std::uint32_t b, float* scratch);

}  // namespace pvol::detail
