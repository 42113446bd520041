#include "volume/simd/choose_batch_kernels.h"

#include "math/processor.h"
#include "pvol/error.h"
#include "volume/simd/batch_kernels.h"

namespace pvol::detail {
namespace {

[[nodiscard]] bool machine_has(KernelKind kernel) {
  return kernel == KernelKind::avx512 ? has_avx512()
                                      : kernel == KernelKind::avx2 && has_x86_64_v3();
}

}  // namespace

bool has_kernel(KernelKind kernel) {
  if (kernel == KernelKind::scalar) return true;
  return machine_has(kernel) && find_batch_kernels(kernel).flights != nullptr;
}

KernelChoice choose_kernel(KernelKind wanted, const char* obstacle, const LaneWords& words) {
  if (wanted == KernelKind::scalar) return {KernelKind::scalar, "as set"};
  if (wanted == KernelKind::automatic) {
    if (obstacle != nullptr) return {KernelKind::scalar, obstacle};
    for (const KernelKind kernel : {KernelKind::avx512, KernelKind::avx2}) {
      if (!has_kernel(kernel)) continue;
      return {kernel,
              (kernel == KernelKind::avx512 ? "16 " : "8 ") + std::string(words.rays) + " at once"};
    }
    return {KernelKind::scalar, "the machine has neither AVX-512 nor AVX2"};
  }
  if (!has_kernel(wanted)) {
    throw Error(std::string("the kernel ") + name(wanted) +
                " does not run on this machine; leave kernel at auto, which chooses one that does");
  }
  if (obstacle != nullptr) {
    throw Error(std::string("the kernel ") + name(wanted) + " does not support this " +
                words.subject + ": " + obstacle + "; leave kernel at auto, or change this");
  }
  return {wanted, "as set"};
}

}  // namespace pvol::detail
