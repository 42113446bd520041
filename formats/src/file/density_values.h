// What becomes of the values in a file: a density is finite and not negative.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>

#include "pvol/formats/vdb.h"

namespace pvol::formats::detail {

/// Counts over a grid; sums of them do not depend on the order.
struct ValueCounts {
  std::uint64_t active = 0, non_finite = 0, negative = 0;
  std::uint64_t stray = 0;  ///< inactive samples that are neither 0 nor the background
  float largest = 0;

  ValueCounts& operator+=(const ValueCounts& o) {
    active += o.active;
    non_finite += o.non_finite;
    negative += o.negative;
    stray += o.stray;
    largest = std::max(largest, o.largest);
    return *this;
  }
};

/// The density of `samples` active samples of value v: v itself, or 0 where v is NaN, infinite or
/// negative.
[[nodiscard]] inline float to_density(float v, std::uint64_t samples, ValueCounts& counts) {
  counts.active += samples;
  if (!std::isfinite(v)) {
    counts.non_finite += samples;
    return 0;
  }
  if (v < 0) {
    counts.negative += samples;
    return 0;
  }
  counts.largest = std::max(counts.largest, v);
  return v > 0 ? v : 0.0f;  // -0 becomes 0
}

/// Whether an inactive sample holds something that is lost: not 0 and not what the whole empty
/// space holds.
[[nodiscard]] inline bool is_stray(float v, float background) {
  return v != 0 && v != background && !(std::isnan(v) && std::isnan(background));
}

/// Fills the counts of `report` and adds a sentence for each thing that was changed; throws Error
/// with these sentences where there are any and `strict` is set.
void finish_report(const std::filesystem::path& file, const ValueCounts& counts, float background,
                   bool strict, GridReport& report);

}  // namespace pvol::formats::detail
