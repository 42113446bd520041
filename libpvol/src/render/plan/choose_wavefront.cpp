#include "render/plan/choose_wavefront.h"

#include "volume/simd/simd_field.h"

namespace pvol::detail {

KernelChoice choose_wavefront(KernelKind wanted) {
  (void)lanes_for(wanted);  // scalar are flights alone
  return choose_kernel(wanted, nullptr, {.rays = "paths", .subject = "scene"});
}

const char* why_one_by_one(const Volume& volume, const RenderOptions& o) {
  if (o.kernel == KernelKind::scalar) return "the kernel is scalar";
  if (o.tracker != Tracker::decomposition) return "the tracker is not decomposition";
  if (o.transmittance == Transmittance::residual_ratio ||
      o.transmittance == Transmittance::regular) {
    return "shadow rays are neither analog nor by ratio";
  }
  if (o.depth) return "the octree's depth is set by the user";
  if (o.majorant_scale != 1) return "majorants are scaled";
  return volume.density.octree.empty() ? nullptr : simd_obstacle(volume);
}

}  // namespace pvol::detail
