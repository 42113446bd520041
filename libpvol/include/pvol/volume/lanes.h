// How many rays a thread follows at once.
#pragma once

#include "pvol/math/names.h"

namespace pvol {

/// How many paths or rays a thread follows at once. What comes of them is the same on average; the
/// random numbers are others in lanes, and the same for any number of them.
enum class Lanes {
  automatic,  ///< as many as the machine has, where lanes serve what is asked for
  scalar,     ///< one at a time
  avx2,       ///< 8
  avx512,     ///< 16
};
[[nodiscard]] constexpr auto names(Lanes) {
  return std::to_array<Named<Lanes>>({
      {Lanes::automatic, "auto"},
      {Lanes::scalar, "scalar"},
      {Lanes::avx2, "avx2"},
      {Lanes::avx512, "avx512"},
  });
}

}  // namespace pvol
