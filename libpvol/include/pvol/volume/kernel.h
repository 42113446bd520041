// How many rays a thread follows at once.
#pragma once

#include "pvol/math/names.h"

namespace pvol {

/// How many flights of paths or rays a thread follows at once. What comes of them is the same on
/// average; the random numbers are others in lanes, and the same for any number of them. So are all
/// bytes, but for those of sse4, which rounds a product before it adds to it.
enum class KernelKind {
  automatic,  ///< as many as the machine has, where lanes serve a volume
  scalar,     ///< one at a time
  sse4,       ///< 4, on older processors of x86
  neon,       ///< 4, on those of ARM
  avx2,       ///< 8
  avx512,     ///< 16
};
[[nodiscard]] constexpr auto names(KernelKind) {
  return std::to_array<Named<KernelKind>>({
      {KernelKind::automatic, "auto"},
      {KernelKind::scalar, "scalar"},
      {KernelKind::sse4, "sse4"},
      {KernelKind::neon, "neon"},
      {KernelKind::avx2, "avx2"},
      {KernelKind::avx512, "avx512"},
  });
}

}  // namespace pvol
