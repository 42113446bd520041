// From what was set to what rays see.
#pragma once

#include "capi/committed.h"

namespace pvol::detail {

/// `before` is what was committed last, or null. Throws Error for what cannot be.
[[nodiscard]] std::unique_ptr<const Committed> build(const Settings& settings,
                                                     const Committed* before,
                                                     const Progress& progress);

}  // namespace pvol::detail
