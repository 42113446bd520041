#include "volume/simd/choose_batch_kernels.h"

#include "math/processor.h"
#include "pvol/error.h"
#include "volume/simd/batch_kernels.h"

namespace pvol::detail {
namespace {

[[nodiscard]] bool machine_has(KernelKind lanes) {
  return lanes == KernelKind::avx512 ? has_avx512() : lanes == KernelKind::avx2 && has_x86_64_v3();
}

}  // namespace

bool has_kernel(KernelKind lanes) {
  if (lanes == KernelKind::scalar) return true;
  return machine_has(lanes) && find_batch_kernels(lanes).flights != nullptr;
}

LaneChoice choose_lanes(KernelKind wanted, const char* obstacle, const LaneWords& words) {
  if (wanted == KernelKind::scalar) return {KernelKind::scalar, "as set"};
  if (wanted == KernelKind::automatic) {
    if (obstacle != nullptr) return {KernelKind::scalar, obstacle};
    for (const KernelKind lanes : {KernelKind::avx512, KernelKind::avx2}) {
      if (!has_kernel(lanes)) continue;
      return {lanes,
              (lanes == KernelKind::avx512 ? "16 " : "8 ") + std::string(words.rays) + " at once"};
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
