// The angle of a point, faster than by the standard library.
#pragma once

#include <algorithm>
#include <cmath>

namespace pvol {

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
