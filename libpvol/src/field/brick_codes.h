// The codes of one brick's samples, and what they tell of its parts.
#pragma once

#include <array>
#include <cstdint>

#include "pvol/field/micro_range.h"
#include "pvol/field/sample_codes.h"

namespace pvol::detail {

/// Writes the codes of 9^3 samples; returns what they stand for.
SampleCodes::Scale code_samples(const float* samples, std::uint8_t* codes);

/// The least and the largest of some codes.
struct CodeRange {
  std::uint8_t lo, hi;
};

/// Those of the codes that look-ups read in the parts of a brick of 2^3 cells each, part (i, j, k)
/// at (i * 4 + j) * 4 + k.
void find_code_ranges(const std::uint8_t* codes, std::array<CodeRange, 64>& ranges);

/// That of all codes of a brick.
[[nodiscard]] CodeRange find_code_range(const std::uint8_t* codes);

/// The densities that nearest and trilinear look-ups can compute among samples with such codes: 0
/// where all samples are.
[[nodiscard]] DensityRange reach_of_codes(SampleCodes::Scale scale, CodeRange range);

}  // namespace pvol::detail
