// Samples as bytes: they decide nearly every tentative collision, and the samples themselves are
// read only where they cannot. Walks do not see them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pvol/field/brick_field.h"
#include "pvol/field/micro_range.h"
#include "pvol/math/pages.h"

namespace pvol {

/// For every brick of a field of 9^3 samples, in its order, a byte for each sample. Code c of a
/// brick stands for base + c * step. What nearest and trilinear look-ups compute at a place is at
/// most kCodeSlack steps away from what they would compute from codes (THEORY.md, T3.10). Where a
/// brick has samples of 0, base is below 0, and code 0 stands for them alone.
struct SampleCodes {
  struct Scale {
    float base, step;
    friend bool operator==(const Scale&, const Scale&) = default;
  };
  /// Behind the last code, so that a word can be read at any.
  static constexpr std::size_t kBeyond = 3;

  std::vector<Scale> scales;  ///< by brick
  /// Of sample i of brick b at b * 9^3 + i, and kBeyond more, which are 0.
  UnsetPagedVector<std::uint8_t> codes;

  /// Makes room for so many bricks, whose scales and codes are still to be set.
  void resize(std::size_t bricks);

  [[nodiscard]] const std::uint8_t* of_brick(std::uint32_t b) const {
    return codes.data() + std::size_t(b) * kFieldSamples;
  }
  [[nodiscard]] std::uint8_t* of_brick(std::uint32_t b) {
    return codes.data() + std::size_t(b) * kFieldSamples;
  }
  [[nodiscard]] std::size_t bytes() const {
    return scales.size() * sizeof(Scale) + codes.size() * sizeof(std::uint8_t);
  }
  friend bool operator==(const SampleCodes&, const SampleCodes&) = default;
};

inline void SampleCodes::resize(std::size_t bricks) {
  scales.resize(bricks);
  codes.resize(bricks * std::size_t(kFieldSamples) + kBeyond);
  std::fill(codes.end() - kBeyond, codes.end(), std::uint8_t(0));
}

/// Half a step is rounded away in codes; the rest is the rounding of look-ups and of codes.
inline constexpr float kCodeSlack = 0.5f + 0x1p-8f;

/// What look-ups at a point of a brick can compute.
template <LookUp kLookUp>
[[nodiscard, gnu::always_inline]] inline DensityRange code_range(const SampleCodes& codes,
                                                                 std::uint32_t brick,
                                                                 const LatticePoint& p) {
  static_assert(has_closed_form(kLookUp));
  const float code = density_in_brick<kLookUp>(codes.of_brick(brick), p);
  const auto [base, step] = codes.scales[brick];
  return {base + (code - kCodeSlack) * step, base + (code + kCodeSlack) * step};
}

/// The codes of a field for nearest and trilinear look-ups, made in parallel; the result does not
/// depend on the number of threads.
[[nodiscard]] SampleCodes build_sample_codes(const BrickField& field);

}  // namespace pvol
