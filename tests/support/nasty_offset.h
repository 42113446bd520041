// Offsets within cells at which interpolation rounds worst.
#pragma once

#include "pvol/math/float4.h"
#include "pvol/math/rng.h"

namespace pvol::test {

/// Next to 0 and 1, in the middle, and anywhere.
[[nodiscard]] inline float nasty_offset(Rng& rng) {
  constexpr float kNasty[] = {0, 0x1p-149f, 0x1p-24f, 0.5f, 0x1.fffffep-1f, 1};
  const auto pick = rng.block().lo % 9;
  return pick < 6 ? kNasty[pick] : rng.uniform();
}
[[nodiscard]] inline Float4 nasty_offsets(Rng& rng) {
  const float x = nasty_offset(rng), y = nasty_offset(rng);
  return Float4{x, y, nasty_offset(rng), 0};
}

}  // namespace pvol::test
