// What testing a shell costs a ray: the model by which fits and renders decide whether one pays.
#pragma once

#include "pvol/shell/shell.h"

namespace pvol {

/// Nanoseconds of one test of a ray that meets the box, in the same unit as WalkCosts; measured
/// with tests/bench/shell_bench. They only affect speed (THEORY.md, T7.5).
struct ShellCosts {
  double hard = 50, hard_perturbation = 7;
  double soft = 60, soft_perturbation = 20;
};

[[nodiscard]] inline double test_cost(ShellKind kind, int perturbations,
                                      const ShellCosts& costs = {}) {
  return kind == ShellKind::hard ? costs.hard + costs.hard_perturbation * perturbations
                                 : costs.soft + costs.soft_perturbation * perturbations;
}
[[nodiscard]] inline double test_cost(const Shell& shell, const ShellCosts& costs = {}) {
  return test_cost(shell.kind, int(shell.form.perturbations.size()), costs);
}

}  // namespace pvol
