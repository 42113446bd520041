// Four points on the unit circle at once.
#pragma once

#include "pvol/math/circle.h"
#include "pvol/math/float4.h"

namespace pvol {

struct CirclePoints {
  Float4 cosine, sine;
  [[nodiscard]] CirclePoint operator[](int i) const { return {cosine[i], sine[i]}; }
};

/// Four of them, to the bit.
[[nodiscard]] inline CirclePoints points_at_turns(Float4 u) {
  const Int4 quarter = truncate_to_int(u * 4 + 0.5f);
  const Float4 f = u - to_float(quarter) * 0.25f, y = f * f;
  const Float4 sine =
      f * (6.2831852878f + y * (-41.341662571f + y * (81.592542871f - y * 75.401612702f)));
  const Float4 cosine =
      0.99999997233f + y * (-19.739152119f + y * (64.921234253f - y * 83.591816778f));
  const Int4 swap = (quarter & 1) != 0;
  const Float4 c = select(swap, sine, cosine), s = select(swap, cosine, sine);
  return {select(((quarter + 1) & 2) != 0, -c, c), select((quarter & 2) != 0, -s, s)};
}

}  // namespace pvol
