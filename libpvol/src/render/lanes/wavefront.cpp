// Compiles the stages once for each instruction set that has a kernel.
#include "render/lanes/wavefront.h"

#include <bit>
#include <cmath>

#include "volume/lanes/targets.h"
#define HWY_TARGET_INCLUDE "render/lanes/wavefront.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET & (HWY_AVX2 | HWY_AVX3)
#include "render/lanes/photons-inl.h"
#endif

#if HWY_ONCE
namespace pvol::detail {

namespace {

/// The functions of one instruction set; none where it was not compiled.
struct Kernels {
  LaneKernel (*find)(bool guided, bool one_lobe) = nullptr;
  PhotonKernel (*find_photons)(bool one_lobe) = nullptr;
};

Kernels kernels_of([[maybe_unused]] Lanes lanes) {
#if HWY_TARGETS & HWY_AVX3
  if (lanes == Lanes::avx512) return {&N_AVX3::find_kernel, &N_AVX3::find_photons};
#endif
#if HWY_TARGETS & HWY_AVX2
  if (lanes == Lanes::avx2) return {&N_AVX2::find_kernel, &N_AVX2::find_photons};
#endif
  return {};
}

}  // namespace

LaneKernel find_lane_kernel(Lanes lanes, bool guided, bool one_lobe) {
  const Kernels k = kernels_of(lanes);
  return k.find == nullptr ? nullptr : k.find(guided, one_lobe);
}

PhotonKernel find_photon_kernel(Lanes lanes, bool one_lobe) {
  const Kernels k = kernels_of(lanes);
  return k.find_photons == nullptr ? nullptr : k.find_photons(one_lobe);
}

}  // namespace pvol::detail
#endif
