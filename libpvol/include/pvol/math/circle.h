// Points on the unit circle, faster than by the standard library.
#pragma once

#include <algorithm>
#include <cmath>

namespace pvol {

struct CirclePoint {
  float cosine, sine;
};

/// Cosine and sine of 2 pi u, each with an absolute error below 2e-7; u in [0, 1]. Interpolating
/// polynomials in the square of the distance to the nearest quarter, a distance that floats hold
/// exactly (errors 3e-8 and 1e-8 before rounding).
[[nodiscard]] inline CirclePoint point_at_turns(float u) {
  const int quarter = static_cast<int>(u * 4 + 0.5f);
  const float f = u - static_cast<float>(quarter) * 0.25f, y = f * f;
  const float sine =
      f * (6.2831852878f + y * (-41.341662571f + y * (81.592542871f - y * 75.401612702f)));
  const float cosine =
      0.99999997233f + y * (-19.739152119f + y * (64.921234253f - y * 83.591816778f));
  const bool swap = quarter & 1;
  const float c = swap ? sine : cosine, s = swap ? cosine : sine;
  return {(quarter + 1) & 2 ? -c : c, quarter & 2 ? -s : s};
}

/// The angle of (x, y) from +x towards +y over 2 pi, in [-0.5, 0.5], with an absolute error below
/// 1e-7; 0 for the origin. By a polynomial for angles up to an eighth of a turn (error 1e-8 before
/// rounding).
[[nodiscard]] inline float turns_of(float y, float x) {
  const float across = std::abs(x), up = std::abs(y);
  const float most = std::max(across, up), q = most > 0 ? std::min(across, up) / most : 0;
  const float s = q * q;
  float t = 0.0037847871f - s * 0.00072571343f;
  for (const float c : {-0.009363046f, 0.0157067872f, -0.0222869285f, 0.0317784067f, -0.0530492275f,
                        0.1591549243f}) {
    t = t * s + c;
  }
  t *= q;
  if (up > across) t = 0.25f - t;
  if (x < 0) t = 0.5f - t;
  return std::copysign(t, y);
}

}  // namespace pvol
