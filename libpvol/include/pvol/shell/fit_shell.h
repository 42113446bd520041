// Fitting a bounding shell to the occupied cells of a cloud.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "pvol/shell/costs.h"
#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol {

inline constexpr int kMaxSoftPerturbations = 32;

struct ShellOptions {
  ShellKind kind = ShellKind::hard;
  /// Number of perturbations, 0 to kMaxPerturbations (hard) or kMaxSoftPerturbations (soft); fewer
  /// are made where no empty cell is left to remove. Without it the number that
  /// costs rays least by the model of THEORY.md, T7.5.
  std::optional<int> perturbations;
  int effort = 1;           ///< factor on the numbers of seeds and iterations, 1 to 10
  Affine index_to_world{};  ///< of the lines that measure tightness, see measure_tightness
};

/// Called from one thread at a time with finished and total steps.
using FitProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// The shell of a support that is not empty: certified with at least `evaluator_margin`, and
/// measured (THEORY.md, T7.4). Deterministic: the same for any number of threads and any speed of
/// the machine, as all effort is counted in iterations. Throws Error for options out of range, an
/// empty support and where no certificate can be found.
[[nodiscard]] Shell fit_shell(const Support& support, const ShellOptions& options = {},
                              const FitProgress& progress = {});

/// Nanoseconds, as in ShellCosts, that the octree takes to find that a ray meets nothing.
inline constexpr double kFalseHitCost = 200;

/// Expected cost for a ray from outside that meets the box: of the test, and of the false hits that
/// it leaves (THEORY.md, T7.5).
[[nodiscard]] double expected_cost(const ShellTightness& tightness, ShellKind kind,
                                   int perturbations);

}  // namespace pvol
