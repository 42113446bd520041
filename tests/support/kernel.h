// The kernel that tests of whole pictures render with.
#pragma once

#include <cstdlib>
#include <optional>
#include <span>
#include <string_view>

#include "pvol/error.h"
#include "pvol/render/plan.h"

namespace pvol::test {

/// Those that this machine has, besides the scalar one.
[[nodiscard]] inline bool serves(KernelKind kernel, std::span<const Volume> volumes, Scene scene) {
  scene.options.kernel = kernel;
  try {
    (void)plan(volumes, scene, {.force = true, .forecast = false});
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// The kernel for a scene that leaves it open: the one that PVOL_TEST_KERNEL names, where it serves
/// the scene, or the plan's choice where that is not set. So a test runs once for each kernel.
[[nodiscard]] inline KernelKind kernel_for(std::span<const Volume> volumes, const Scene& scene) {
  const char* const wanted = std::getenv("PVOL_TEST_KERNEL");
  if (wanted == nullptr || scene.options.kernel != KernelKind::automatic)
    return scene.options.kernel;
  for (const auto& [kernel, name] : names(KernelKind{})) {
    if (std::string_view(wanted) == name) {
      return serves(kernel, volumes, scene) ? kernel : KernelKind::scalar;
    }
  }
  throw Error("PVOL_TEST_KERNEL is " + std::string(wanted) + ", which is no kernel");
}

}  // namespace pvol::test
