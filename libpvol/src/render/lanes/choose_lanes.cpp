#include "render/lanes/choose_lanes.h"

#include "math/processor.h"
#include "pvol/error.h"
#include "render/lanes/wavefront.h"

namespace pvol::detail {
namespace {

[[nodiscard]] bool machine_has(Lanes lanes) {
  return lanes == Lanes::avx512 ? has_avx512() : lanes == Lanes::avx2 && has_x86_64_v3();
}

[[nodiscard]] std::string lanes_of(Lanes lanes) {
  return lanes == Lanes::avx512 ? "16 paths at once" : "8 paths at once";
}

}  // namespace

bool has_kernel(Lanes lanes) {
  if (lanes == Lanes::scalar) return true;
  return machine_has(lanes) && find_lane_kernel(lanes, false, true) != nullptr;
}

LaneChoice choose_lanes(std::span<const Volume> volumes, const Scene& scene) {
  const Lanes wanted = scene.options.kernel;
  if (wanted == Lanes::scalar) return {Lanes::scalar, "as told"};
  const char* const obstacle = lane_obstacle(volumes, scene);
  if (wanted == Lanes::automatic) {
    if (obstacle != nullptr) return {Lanes::scalar, obstacle};
    for (const Lanes lanes : {Lanes::avx512, Lanes::avx2}) {
      if (has_kernel(lanes)) return {lanes, lanes_of(lanes)};
    }
    return {Lanes::scalar, "the machine has neither AVX-512 nor AVX2"};
  }
  if (!has_kernel(wanted)) {
    throw Error(std::string("the kernel ") + name(wanted) +
                " does not run on this machine; leave kernel at auto, which takes what there is");
  }
  if (obstacle != nullptr) {
    throw Error(std::string("the kernel ") + name(wanted) + " does not serve this scene: " +
                obstacle + "; leave kernel at auto, or change that");
  }
  return {wanted, "as told"};
}

}  // namespace pvol::detail
