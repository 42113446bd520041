// The samples of a volume's field by brick, wherever it has them.
#pragma once

#include "field/brick_samples.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// f(bricks), and its result, with what has the samples of a field that is no recipe.
template <class F>
decltype(auto) visit_bricks(const VolumeField& field, const F& f) {
  return field.shares_samples() ? f(field.shared()) : f(field.bricks());
}

[[nodiscard]] inline std::size_t count_bricks(const VolumeField& field) {
  return visit_bricks(field, [](const auto& bricks) { return bricks.bricks(); });
}

/// As samples_of a BrickField, for nearest and trilinear look-ups.
[[nodiscard]] inline const float* samples_of(const VolumeField& field, std::uint32_t b,
                                             float* scratch) {
  return visit_bricks(field, [&](const auto& bricks) { return samples_of(bricks, b, scratch); });
}

}  // namespace pvol::detail
