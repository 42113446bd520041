#include "volume/lanes/choose_lanes.h"

#include "math/processor.h"
#include "pvol/error.h"
#include "volume/lanes/batch_kernels.h"

namespace pvol::detail {
namespace {

[[nodiscard]] bool machine_has(Lanes lanes) {
  return lanes == Lanes::avx512 ? has_avx512() : lanes == Lanes::avx2 && has_x86_64_v3();
}

}  // namespace

bool has_kernel(Lanes lanes) {
  if (lanes == Lanes::scalar) return true;
  return machine_has(lanes) && find_batch_kernels(lanes).flights != nullptr;
}

LaneChoice choose_lanes(Lanes wanted, const char* obstacle, const LaneWords& words) {
  if (wanted == Lanes::scalar) return {Lanes::scalar, "as told"};
  if (wanted == Lanes::automatic) {
    if (obstacle != nullptr) return {Lanes::scalar, obstacle};
    for (const Lanes lanes : {Lanes::avx512, Lanes::avx2}) {
      if (!has_kernel(lanes)) continue;
      return {lanes,
              (lanes == Lanes::avx512 ? "16 " : "8 ") + std::string(words.rays) + " at once"};
    }
    return {Lanes::scalar, "the machine has neither AVX-512 nor AVX2"};
  }
  if (!has_kernel(wanted)) {
    throw Error(std::string("the kernel ") + name(wanted) +
                " does not run on this machine; leave kernel at auto, which takes what there is");
  }
  if (obstacle != nullptr) {
    throw Error(std::string("the kernel ") + name(wanted) + " does not serve this " +
                words.subject + ": " + obstacle + "; leave kernel at auto, or change that");
  }
  return {wanted, "as told"};
}

}  // namespace pvol::detail
