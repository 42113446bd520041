// The kernels of lanes that this machine has.
#pragma once

#include <vector>

#include "pvol/volume/best_kernel.h"
#include "support/effort.h"

namespace pvol::test {

/// From few lanes to many.
[[nodiscard]] inline std::vector<KernelKind> simd_kernels() {
  std::vector<KernelKind> all;
  for (const KernelKind kernel :
       {KernelKind::sse4, KernelKind::neon, KernelKind::avx2, KernelKind::avx512}) {
    if (has_kernel(kernel)) all.push_back(kernel);
  }
  return all;
}

/// Those for tests of every scene that render each several times: on each commit the widest.
[[nodiscard]] inline std::vector<KernelKind> kernels_to_try() {
  std::vector<KernelKind> all = simd_kernels();
  if (!proof::runs_all() && !all.empty()) all.erase(all.begin(), all.end() - 1);
  return all;
}

/// Those of them whose bytes are the same: they add to products that are not rounded.
[[nodiscard]] inline std::vector<KernelKind> fusing_kernels() {
  std::vector<KernelKind> all = simd_kernels();
  std::erase(all, KernelKind::sse4);
  return all;
}

}  // namespace pvol::test
