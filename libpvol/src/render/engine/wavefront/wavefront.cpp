// Compiles the stages once for each instruction set that has a kernel.
#include "render/engine/wavefront/wavefront.h"

#include "math/instruction_sets.h"
#define HWY_TARGET_INCLUDE "render/engine/wavefront/wavefront.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET & PVOL_TARGETS_WITH_LANES
#include "render/engine/wavefront/many-inl.h"
#include "render/engine/wavefront/photons-inl.h"
#endif

#if HWY_ONCE
namespace pvol::detail {

namespace {

/// The functions of one instruction set; none where it was not compiled.
struct Kernels {
  WavefrontKernel (*find)(bool guided, bool one_lobe, bool many) = nullptr;
  PhotonKernel (*find_photons)(bool one_lobe, bool many) = nullptr;
};

Kernels kernels_of([[maybe_unused]] KernelKind kernel) {
#if HWY_TARGETS & HWY_AVX3
  if (kernel == KernelKind::avx512) return {&N_AVX3::find_kernel, &N_AVX3::find_photons};
#endif
#if HWY_TARGETS & HWY_AVX2
  if (kernel == KernelKind::avx2) return {&N_AVX2::find_kernel, &N_AVX2::find_photons};
#endif
#if HWY_TARGETS & HWY_SSE4
  if (kernel == KernelKind::sse4) return {&N_SSE4::find_kernel, &N_SSE4::find_photons};
#endif
#if HWY_TARGETS & HWY_NEON
  if (kernel == KernelKind::neon) return {&N_NEON::find_kernel, &N_NEON::find_photons};
#endif
  return {};
}

}  // namespace

WavefrontKernel find_wavefront_kernel(KernelKind kernel, bool guided, const WavefrontScene& scene) {
  const Kernels k = kernels_of(kernel);
  return k.find == nullptr ? nullptr : k.find(guided, scene.one_lobe, scene.many);
}

PhotonKernel find_photon_kernel(KernelKind kernel, const WavefrontScene& scene) {
  const Kernels k = kernels_of(kernel);
  return k.find_photons == nullptr ? nullptr : k.find_photons(scene.one_lobe, scene.many);
}

}  // namespace pvol::detail
#endif
