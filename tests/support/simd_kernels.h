// The kernels of lanes that this machine has.
#pragma once

#include <vector>

#include "volume/simd/choose_batch_kernels.h"

namespace pvol::test {

/// From few lanes to many.
[[nodiscard]] inline std::vector<KernelKind> simd_kernels() {
  std::vector<KernelKind> all;
  for (const KernelKind kernel : {KernelKind::avx2, KernelKind::avx512}) {
    if (detail::has_kernel(kernel)) all.push_back(kernel);
  }
  return all;
}

}  // namespace pvol::test
