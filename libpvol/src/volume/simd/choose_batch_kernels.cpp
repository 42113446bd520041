#include "volume/simd/choose_batch_kernels.h"

#include "math/processor.h"
#include "pvol/error.h"
#include "volume/simd/batch_kernels.h"

namespace pvol::detail {
namespace {

[[nodiscard]] bool machine_has(KernelKind kernel) {
  switch (kernel) {
    case KernelKind::avx512:
      return has_avx512();
    case KernelKind::avx2:
      return has_x86_64_v3();
    case KernelKind::sse4:
      return has_sse4();
    case KernelKind::neon:
      return has_neon();
    default:
      return kernel == KernelKind::scalar;
  }
}

[[nodiscard]] int lanes_of(KernelKind kernel) {
  return kernel == KernelKind::avx512 ? 16 : kernel == KernelKind::avx2 ? 8 : 4;
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
    for (const KernelKind kernel :
         {KernelKind::avx512, KernelKind::avx2, KernelKind::sse4, KernelKind::neon}) {
      if (!has_kernel(kernel)) continue;
      return {kernel, std::to_string(lanes_of(kernel)) + ' ' + words.rays + " at once"};
    }
    return {KernelKind::scalar,
            "the machine has no vector instructions that there is a kernel for"};
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
