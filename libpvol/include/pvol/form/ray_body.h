// Where rays meet the surface of a body, in closed form.
#pragma once

#include <optional>
#include <vector>

#include "pvol/form/body.h"

namespace pvol {

/// A body made ready for rays. Immutable; safe to use from any thread.
///
/// Along a ray the value of each form is a polynomial of degree four between the places where a
/// perturbation begins or ends to act, which are roots of quadratics (THEORY.md, T7.7). Unlike a
/// RayShell, which promises to hold a set, this finds the surface itself, to about 1e-14 of the
/// diagonal of the body's box, and less where the ray only grazes it.
class RayBody {
 public:
  /// Throws Error for a body that is not bounded, and for perturbations of perturbations, whose
  /// values along a ray have degree eight.
  explicit RayBody(const Body& body);
  RayBody(const RayBody&) = delete;  // the view refers to the body
  RayBody& operator=(const RayBody&) = delete;

  struct Hit {
    double t;
    Vec3d normal;  ///< along the gradient of the form that ends there; of any length, may be 0
  };
  /// The first t in (t0, t1) at which the ray enters or leaves the body; nothing where it does not.
  [[nodiscard]] std::optional<Hit> first_hit(const Ray& ray, double t0, double t1) const;

  /// Around the body.
  [[nodiscard]] const Box& box() const { return box_; }

 private:
  struct Crossing;
  void add_crossings(const FreeForm& form, const Ray& segment, std::vector<Crossing>& all) const;

  Body body_;
  BodyView view_;
  std::vector<const FreeForm*> forms_;
  Box box_;
};

}  // namespace pvol
