// Which kernel follows rays.
#pragma once

#include <string>

#include "pvol/volume/kernel.h"

namespace pvol::detail {

struct KernelChoice {
  KernelKind kernel = KernelKind::scalar;  ///< not automatic
  std::string reason;
};

/// What messages call that which is to be traced: "paths" of a "scene".
struct LaneWords {
  const char* rays;
  const char* subject;
};

/// The most lanes that the machine has, where there is no obstacle (else null), or what is wanted.
/// Throws Error where that is a kernel that cannot do it.
[[nodiscard]] KernelChoice choose_kernel(KernelKind wanted, const char* obstacle,
                                         const LaneWords& words);

/// The kernel itself, or the machine's best instead of `scalar` and `automatic`. Throws Error where
/// there is none.
[[nodiscard]] KernelKind lanes_for(KernelKind kernel);

}  // namespace pvol::detail
