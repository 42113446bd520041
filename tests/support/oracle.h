// What trackers and walks must agree with: densities and optical depths of a test field in double,
// straight from the definitions and sharing no code with the library.
#pragma once

#include <limits>
#include <vector>

#include "pvol/math/box.h"
#include "support/fields.h"

namespace pvol::test {

/// Density of the field at a point of index space.
[[nodiscard]] double density_at(const Field& field, LookUp look_up, Vec3d p);

/// Density along the ray o + t d, 0 <= t <= end, in index space: zero outside the intervals between
/// knots, in each of which it is a polynomial of t: of degree 3 (trilinear), 9 (tricubic) or 0
/// (nearest).
class RayOracle {
 public:
  /// `extinction` is per unit of t and density. The direction need not be of unit length.
  RayOracle(const Field& field, LookUp look_up, const Ray& ray, double extinction,
            double end = std::numeric_limits<double>::infinity());

  [[nodiscard]] double extinction(double t) const;     ///< mu_t at t
  [[nodiscard]] double optical_depth(double t) const;  ///< int_0^t mu_t; t may be infinite
  [[nodiscard]] double optical_depth() const { return depth_.empty() ? 0 : depth_.back(); }
  [[nodiscard]] double transmittance() const { return std::exp(-optical_depth()); }

  /// Probability of a collision before t.
  [[nodiscard]] double cdf(double t) const { return -std::expm1(-optical_depth(t)); }
  /// The least t up to which the optical depth is `depth`, in [0, optical_depth()].
  [[nodiscard]] double inverse_optical_depth(double depth) const;

  /// Where the ray enters a cell, ascending; at least two, or none where it misses the field's box.
  [[nodiscard]] const std::vector<double>& knots() const { return knots_; }

 private:
  [[nodiscard]] double in_piece(std::size_t piece, double t) const;
  [[nodiscard]] double integral(std::size_t piece, double t) const;
  [[nodiscard]] std::size_t piece_at(double t) const;

  const Field* field_;
  LookUp look_up_;
  Ray ray_;
  double scale_;
  std::vector<double> knots_, depth_;  // places, and optical depths there
};

}  // namespace pvol::test
