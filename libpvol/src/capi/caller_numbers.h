// Random numbers of the caller's, as trackers take them.
#pragma once

#include <algorithm>
#include <cmath>

#include "pvol/math/rng.h"
#include "pvol/pvol.h"

namespace pvol::detail {

/// pvol's own stream of a pvol_random, from where it stands.
[[nodiscard]] inline Rng own_stream(const pvol_random& r) {
  return Rng(Rng::State{r.key[0], r.key[1], r.used});
}

/// Whether all numbers to come are those of pvol's own stream.
[[nodiscard]] inline bool is_own(const pvol_random& r) {
  return r.next == nullptr && r.taken >= r.count;
}

/// A number of somebody's as one in [0, 1), whatever it was.
[[nodiscard]] inline double in_unit(double x) {
  constexpr double kBelowOne = 1 - 0x1p-53;
  return x >= 0 ? std::min(x, kBelowOne) : 0.0;
}

/// Answers the questions of Rng by the caller's numbers: those of the function, or those of the
/// array as long as there are any, and then those of the stream.
class CallerNumbers {
 public:
  explicit CallerNumbers(pvol_random& random) : random_(random) {}

  [[nodiscard]] double one() {
    if (random_.next != nullptr) return in_unit(random_.next(random_.user));
    if (random_.taken < random_.count) return in_unit(double(random_.numbers[random_.taken++]));
    return to_uniform_double(take().block().lo);
  }

  [[nodiscard]] float uniform() { return to_float(one()); }

  [[nodiscard]] Rng::Tentative tentative() {
    if (is_own(random_)) return take().tentative();
    const double a = one();
    return {float(-std::log1p(-a)), to_float(one())};
  }

 private:
  pvol_random& random_;

  [[nodiscard]] static float to_float(double x) { return std::min(float(x), 0x1.fffffep-1f); }
  /// The stream at its next block, which is used up.
  [[nodiscard]] Rng take() {
    const Rng rng = own_stream(random_);
    ++random_.used;
    return rng;
  }
};

}  // namespace pvol::detail
