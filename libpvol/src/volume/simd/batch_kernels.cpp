// Compiles the kernels of batches once for each instruction set that has them.
#include "volume/simd/batch_kernels.h"

#include "math/instruction_sets.h"
#define HWY_TARGET_INCLUDE "volume/simd/batch_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET & PVOL_TARGETS_WITH_LANES
#include "volume/simd/batch-inl.h"
#endif

#if HWY_ONCE
namespace pvol::detail {

BatchKernels find_batch_kernels([[maybe_unused]] KernelKind kernel) {
#if HWY_TARGETS & HWY_AVX3
  if (kernel == KernelKind::avx512) return N_AVX3::batch_kernels();
#endif
#if HWY_TARGETS & HWY_AVX2
  if (kernel == KernelKind::avx2) return N_AVX2::batch_kernels();
#endif
#if HWY_TARGETS & HWY_SSE4
  if (kernel == KernelKind::sse4) return N_SSE4::batch_kernels();
#endif
#if HWY_TARGETS & HWY_NEON
  if (kernel == KernelKind::neon) return N_NEON::batch_kernels();
#endif
  return {};
}

}  // namespace pvol::detail
#endif
