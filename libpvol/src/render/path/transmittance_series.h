// Transmittances of lines whose optical depths are known on average alone (THEORY.md, T5.26).
#pragma once

#include <algorithm>
#include <cmath>

#include "pvol/math/rng.h"
#include "pvol/math/vec.h"

namespace pvol::detail {

/// exp(-tau) of each channel, right on average: by a pivot near tau and depth(), which gives
/// independent estimates of tau that are right on average and do not depend on the pivot. The
/// closer both are to tau, the less it varies: with a deviation of s by about s exp(-tau). Finite
/// where the pivot and the estimates lie within 80 of each other.
/// Based on: Kettunen, d'Eon, Pantaleoni, Novak. An unbiased ray-marching transmittance estimator.
/// 2021, without its combinations of many estimates.
template <class Depth>
[[nodiscard]] Rgb transmittance_around(Rgb pivot, const Depth& depth, Rng& rng) {
  Vec3d term(1.0), sum(1.0);
  for (int k = 1;; ++k) {
    const Rgb tau = depth();
    for (int c = 0; c < 3; ++c) {
      term[c] *= (double(pivot[c]) - double(tau[c])) / k;
      sum[c] += term[c];
    }
    const double size = std::max({std::abs(term.x), std::abs(term.y), std::abs(term.z)});
    if (size >= 1) continue;
    if (!(double(rng.uniform()) < size)) break;
    term *= 1 / size;
  }
  Rgb t;
  for (int c = 0; c < 3; ++c) t[c] = float(std::exp(-double(pivot[c])) * sum[c]);
  return t;
}

}  // namespace pvol::detail
