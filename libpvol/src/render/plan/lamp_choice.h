// Whether asking lamps along flights pays.
#pragma once

#include <span>
#include <vector>

#include "pvol/render/lighting.h"
#include "pvol/render/plan.h"

namespace pvol::detail {

struct LampChoice {
  std::vector<bool> along_flights{};  ///< for each volume, whether flights ask lamps all along
  const char* reason = nullptr;       ///< null without lamps or volumes
};

/// As the options say, or where volumes are thin and lamps bring much of the light (THEORY.md,
/// T5.25).
[[nodiscard]] LampChoice choose_lamps(std::span<const Volume> volumes, const Scene& scene,
                                      const Lighting& lighting);

/// Of a choice with a reason.
[[nodiscard]] Decision in_words(const LampChoice& choice);

}  // namespace pvol::detail
