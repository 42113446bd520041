// Free forms: a base quadric with perturbations, after the method's second-order functions.
#pragma once

#include <cstddef>
#include <vector>

#include "pvol/form/quadric.h"

namespace pvol {

struct Perturbation;

/// F'(p) = F(p) + sum_i a_i max(0, Q_i(p))^2 with the base F, strengths a_i and forms Q_i, most of
/// them plain quadrics. Inside is F' >= 0.
struct FreeForm {
  Quadric base;
  std::vector<Perturbation> perturbations;
  friend bool operator==(const FreeForm&, const FreeForm&);
};

/// Adds strength * max(0, Q)^2: acts only inside its form, C1 across its surface. A positive
/// strength bulges the form it belongs to, a negative one dents it. Q may have perturbations of its
/// own (nesting).
struct Perturbation {
  FreeForm form;
  double strength = 0;
  friend bool operator==(const Perturbation&, const Perturbation&) = default;
};

inline bool operator==(const FreeForm& a, const FreeForm& b) {
  return a.base == b.base && a.perturbations == b.perturbations;
}

[[nodiscard]] double value(const FreeForm& form, Vec3d p);

/// grad F' = grad F + sum_i 2 a_i max(0, Q_i) grad Q_i.
[[nodiscard]] Vec3d gradient(const FreeForm& form, Vec3d p);

/// Bound on |computed - exact| of value(form, p) for p in the box.
[[nodiscard]] double rounding_error(const FreeForm& form, const Box& box);

/// Holds F'(p), exact and as value() computes it, for every p of the finite box: the natural form,
/// from the ranges of F and Q_i, cut with a second-order form whose excess falls with the square of
/// the box's size, and with its cube where no Q_i changes its sign (THEORY.md, T7.1). About 50 ns
/// for each perturbation that acts in the box, less for the others.
[[nodiscard]] Interval range(const FreeForm& form, const Box& box);

/// A box that holds {F' >= level}, infinite where that is not seen to be bounded: F' >= level > F
/// only where some a_i > 0 has Q_i > 0.
[[nodiscard]] Box bounds(const FreeForm& form, double level = 0);

/// k F', k > 0: the same body with other values.
[[nodiscard]] FreeForm operator*(double k, const FreeForm& form);

/// The base and those of perturbations, of whatever level.
[[nodiscard]] std::size_t count_quadrics(const FreeForm& form);

/// The moved body: transform(a, form)(a(p)) = form(p). The map must be invertible.
[[nodiscard]] FreeForm transform(const Affine& map, const FreeForm& form);

}  // namespace pvol
