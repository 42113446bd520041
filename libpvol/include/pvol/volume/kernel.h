// How many rays a thread follows at once.
#pragma once

#include "pvol/math/names.h"

namespace pvol {

/// How many paths or rays a thread follows at once. What comes of them is the same on average; the
/// random numbers are others in lanes, and the same for any number of them.
enum class KernelKind {
  automatic,  ///< as many as the machine has, where lanes serve what is asked for
  scalar,     ///< one at a time
  avx2,       ///< 8
  avx512,     ///< 16
};
[[nodiscard]] constexpr auto names(KernelKind) {
  return std::to_array<Named<KernelKind>>({
      {KernelKind::automatic, "auto"},
      {KernelKind::scalar, "scalar"},
      {KernelKind::avx2, "avx2"},
      {KernelKind::avx512, "avx512"},
  });
}

}  // namespace pvol
