// Free forms: a base quadric with perturbations, after the method's second-order functions.
#pragma once

#include <vector>

#include "pvol/shell/quadric.h"

namespace pvol {

/// Adds strength * max(0, Q)^2: acts only inside its quadric, C1 across its surface. A positive
/// strength bulges the form, a negative one dents it.
struct Perturbation {
  Quadric quadric;
  double strength = 0;
  friend bool operator==(const Perturbation&, const Perturbation&) = default;
};

/// F'(p) = F(p) + sum_i a_i max(0, Q_i(p))^2 with the base F, strengths a_i and quadrics Q_i.
/// Inside is F' >= 0.
struct FreeForm {
  Quadric base;
  std::vector<Perturbation> perturbations;
  friend bool operator==(const FreeForm&, const FreeForm&) = default;
};

[[nodiscard]] double value(const FreeForm& form, Vec3d p);

/// grad F' = grad F + sum_i 2 a_i max(0, Q_i) grad Q_i.
[[nodiscard]] Vec3d gradient(const FreeForm& form, Vec3d p);

/// Holds F'(p), as value() computes it, for every p of the finite box: the natural form, from the
/// exact ranges of F and Q_i, cut with the mean value form F'(m) + grad F'(box) . (p - m), whose
/// excess falls with the square of the box's size.
[[nodiscard]] Interval range(const FreeForm& form, const Box& box);

/// A box that holds {F' >= level}, infinite where that is not seen to be bounded: F' >= level > F
/// only where some a_i > 0 has Q_i > 0.
[[nodiscard]] Box bounds(const FreeForm& form, double level = 0);

/// k F', k > 0: the same body with other values.
[[nodiscard]] FreeForm operator*(double k, const FreeForm& form);

/// The moved body: transform(a, form)(a(p)) = form(p). The map must be invertible.
[[nodiscard]] FreeForm transform(const Affine& map, const FreeForm& form);

}  // namespace pvol
