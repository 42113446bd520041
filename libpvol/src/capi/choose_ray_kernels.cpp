#include "capi/ray_kernels.h"
#include "math/processor.h"

namespace pvol::detail {

RayKernels find_ray_kernels(const RayKind& kind) {
#ifdef PVOL_HAS_V3
  if (has_x86_64_v3()) return find_v3_ray_kernels(kind);
#endif
  return find_baseline_ray_kernels(kind);
}

}  // namespace pvol::detail
