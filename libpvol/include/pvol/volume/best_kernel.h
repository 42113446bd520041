// Which kernels this machine has.
#pragma once

#include "pvol/volume/kernel.h"

namespace pvol {

/// Whether this machine and this build have such a kernel; `scalar` and `automatic` always.
[[nodiscard]] bool has_kernel(KernelKind kernel);

/// The kernel with the most lanes that there is.
[[nodiscard]] KernelKind best_kernel();

}  // namespace pvol
