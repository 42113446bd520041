#include "volume/simd/choose_batch_kernels.h"

#include "math/processor.h"
#include "pvol/error.h"
#include "pvol/volume/best_kernel.h"
#include "volume/simd/batch_kernels.h"

namespace pvol {
namespace {

[[nodiscard]] bool machine_has(KernelKind kernel) {
  switch (kernel) {
    case KernelKind::avx512:
      return detail::has_avx512();
    case KernelKind::avx2:
      return detail::has_x86_64_v3();
    case KernelKind::sse4:
      return detail::has_sse4();
    case KernelKind::neon:
      return detail::has_neon();
    default:
      return kernel == KernelKind::scalar;
  }
}

[[nodiscard]] int lanes_of(KernelKind kernel) {
  return kernel == KernelKind::avx512 ? 16 : kernel == KernelKind::avx2 ? 8 : 4;
}

}  // namespace

bool has_kernel(KernelKind kernel) {
  if (kernel == KernelKind::scalar || kernel == KernelKind::automatic) return true;
  return machine_has(kernel) && detail::find_batch_kernels(kernel).flights != nullptr;
}

KernelKind best_kernel() {
  for (const KernelKind kernel :
       {KernelKind::avx512, KernelKind::avx2, KernelKind::sse4, KernelKind::neon}) {
    if (has_kernel(kernel)) return kernel;
  }
  return KernelKind::scalar;
}

namespace detail {

KernelKind lanes_for(KernelKind kernel) {
  if (kernel != KernelKind::scalar && kernel != KernelKind::automatic) return kernel;
  const KernelKind best = best_kernel();
  if (best != KernelKind::scalar) return best;
  throw Error(
      "this machine has no vector instructions that paths are followed by; expected SSE 4.1 or "
      "NEON "
      "at least");
}

KernelChoice choose_kernel(KernelKind wanted, const char* obstacle, const LaneWords& words) {
  if (wanted == KernelKind::scalar) return {KernelKind::scalar, "as set"};
  if (wanted == KernelKind::automatic) {
    if (obstacle != nullptr) return {KernelKind::scalar, obstacle};
    const KernelKind best = best_kernel();
    if (best == KernelKind::scalar)
      return {best, "the machine has no vector instructions that there is a kernel for"};
    return {best, std::to_string(lanes_of(best)) + ' ' + words.rays + " at once"};
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

}  // namespace detail
}  // namespace pvol
