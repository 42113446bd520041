// Compiles the kernels of batches once for each instruction set that has them.
#include "volume/lanes/batch_kernels.h"

#include "volume/lanes/targets.h"
#define HWY_TARGET_INCLUDE "volume/lanes/batch_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET & (HWY_AVX2 | HWY_AVX3)
#include "volume/lanes/batch-inl.h"
#endif

#if HWY_ONCE
namespace pvol::detail {

BatchKernels find_batch_kernels([[maybe_unused]] Lanes lanes) {
#if HWY_TARGETS & HWY_AVX3
  if (lanes == Lanes::avx512) return N_AVX3::batch_kernels();
#endif
#if HWY_TARGETS & HWY_AVX2
  if (lanes == Lanes::avx2) return N_AVX2::batch_kernels();
#endif
  return {};
}

}  // namespace pvol::detail
#endif
