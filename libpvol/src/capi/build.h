// From what was set to what rays see.
#pragma once

#include <functional>

#include "capi/committed.h"

namespace pvol::detail {

/// Called with the share of a commit that is done; throws Cancelled where it is to end.
using Progress = std::function<void(double done)>;

/// `before` is what was committed last, or null. Throws Error for what cannot be.
[[nodiscard]] std::unique_ptr<const Committed> build(const Settings& settings,
                                                     const Committed* before,
                                                     const Progress& progress);

}  // namespace pvol::detail
