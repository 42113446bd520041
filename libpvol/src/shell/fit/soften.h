// From dents to a smooth surface: all coefficients of a soft shell at once.
#pragma once

#include <functional>

#include "pvol/form/free_form.h"
#include "shell/fit/support_lattice.h"

namespace pvol::detail {

/// F - sum_i max(0, Q_i)^2 that is at least 0 on the support, but for a tolerance that the final
/// certificate makes up for, and below 0 on as many of the empty cells as can be: started from
/// quadrics R_j as `Dents` finds them, with F = -R_0 and Q_i a multiple of R_i, all coefficients
/// optimised together (THEORY.md, T7.4). `tick` is called kSoftTicks times. In parallel; the same
/// for any number of threads.
inline constexpr int kSoftTicks = 25;
[[nodiscard]] FreeForm soften(const Support& support, const SupportLattice& lattice,
                              const std::vector<Quadric>& quadrics, int effort,
                              const std::function<void()>& tick);

}  // namespace pvol::detail
