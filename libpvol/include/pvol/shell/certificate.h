// The proof that a shell holds every occupied cell, by branch and bound with outward rounding.
#pragma once

#include <limits>

#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol {

/// How far branch and bound goes. It stops dividing a box as soon as nothing in it can lower the
/// bound by more than `tolerance`, or brings it below `enough`, or its edge is 2^deepest cells.
struct CertifyOptions {
  double tolerance = 1e-6;  ///< in units of the form's values
  int deepest = -6;
  double enough = std::numeric_limits<double>::infinity();
};
/// Lower bound on the shell's slack over all occupied cells, closed, within `tolerance` of the true
/// minimum unless one of the other limits came first. Depth first over the support's octree, full
/// nodes as whole boxes, single cells divided further where needed. The bound holds for the
/// coefficients as they are, for the exact slack and for the one computed in double (THEORY.md,
/// T7.2). Infinite without cells. Sequential, so the same on every machine.
[[nodiscard]] Certificate certify(const Shell& shell, const Support& support,
                                  const CertifyOptions& options = {});

/// Upper bound on the form's value, nested or not, over all occupied cells; as above, with options
/// for the negative of the form: it stops at or below -enough. Dents of hard shells need it to be
/// negative.
[[nodiscard]] Certificate certify_above(const FreeForm& form, const Support& support,
                                        const ShellFrame& frame,
                                        const CertifyOptions& options = {});

/// The least slack that covers every error of the ray evaluator, so that an occupied point on a ray
/// lies inside the spans that it computes: shells are only written with a certified bound at or
/// above this. It is the excess of RayShell for rays from two diagonals away; RayShell itself
/// covers its errors at any distance, so this is for evaluators that do not (THEORY.md, T7.3).
[[nodiscard]] double evaluator_margin(const Shell& shell);

}  // namespace pvol
