// Second-order Taylor forms: what bounds of free forms over boxes are made of.
#pragma once

#include "pvol/form/free_form.h"

namespace pvol {

/// Encloses a form over the box of all c + d, |d_i| <= h_i, by a quadric in d and a rest:
/// local(d) + rest.lo <= form(c + d) <= local(d) + rest.hi (THEORY.md, T7.1). The enclosure holds
/// for exact arithmetic; what rounding does to it is part of the rest. Based on: Makino, Berz.
/// Taylor Models and Other Validated Functional Inclusion Methods. 2003.
struct TaylorForm {
  Quadric local;
  Interval rest;
  Interval values;  ///< holds all values of the form over the box
};

[[nodiscard]] TaylorForm expand(const Quadric& q, Vec3d centre, Vec3d half);
[[nodiscard]] TaylorForm expand(const FreeForm& form, Vec3d centre, Vec3d half);

/// A lower bound on q(d) for |d_i| <= half_i, but for rounding, and the place where q comes close
/// to it. Attained unless two axes with a mixed term both have their minima inside.
struct Least {
  double bound;
  Vec3d where;
};
[[nodiscard]] Least least(const Quadric& q, Vec3d half);

/// A sum of strength * max(0, form)^2 over a base, term by term, over a box of half extents `half`.
class TaylorSum {
 public:
  explicit TaylorSum(const TaylorForm& base, Vec3d half);
  /// False if the form is nowhere positive in the box: then so it is in every part of it.
  bool add(double strength, const TaylorForm& form);
  [[nodiscard]] TaylorForm enclosure() const;
  /// A lower bound, and a place near that of the minimum.
  [[nodiscard]] Least least() const;

 private:
  [[nodiscard]] double rounding() const;

  Vec3d half_;
  TaylorForm sum_;  ///< but for rounding
  double magnitude_;
  int terms_ = 1;
};

}  // namespace pvol
