// Bodies: unions, intersections and differences of free forms.
#pragma once

#include <cstddef>
#include <vector>

#include "pvol/form/free_form.h"

namespace pvol {

/// How the parts of a body make its value.
enum class BodyOp {
  form,          ///< no parts: the value of a free form
  join,          ///< the union: max over the parts
  intersection,  ///< min over the parts
  difference     ///< the first part without the others: min(part_1, -part_2, -part_3, ...)
};

/// A tree of free forms; inside is value >= 0. Where the values of two parts are at most the
/// distances from their surfaces, so is that of the whole (Ricci. A Constructive Geometry for
/// Computer Graphics. 1973): it has creases where they meet, but no jumps.
struct Body {
  BodyOp op = BodyOp::form;
  FreeForm form;            ///< of BodyOp::form
  std::vector<Body> parts;  ///< of the others, at least one

  Body() = default;
  Body(FreeForm f) : form(std::move(f)) {}  // NOLINT: a form is a body
  Body(BodyOp o, std::vector<Body> p) : op(o), parts(std::move(p)) {}
  friend bool operator==(const Body&, const Body&) = default;
};

[[nodiscard]] double value(const Body& body, Vec3d p);

/// Holds value(body, p) for every p of the finite box.
[[nodiscard]] Interval range(const Body& body, const Box& box);

/// A box that holds {value >= level}, infinite where that is not seen to be bounded.
[[nodiscard]] Box bounds(const Body& body, double level = 0);

/// k body, k > 0: the same body with other values.
[[nodiscard]] Body operator*(double k, const Body& body);

/// The moved body: transform(a, body)(a(p)) = body(p). The map must be invertible.
[[nodiscard]] Body transform(const Affine& map, const Body& body);

/// Quadrics in the tree, those of perturbations included, and the levels of parts above the lowest.
[[nodiscard]] std::size_t count_quadrics(const Body& body);
[[nodiscard]] int depth(const Body& body);

/// Those forms of a body that decide its value in the box at hand: a tree of max and min over forms
/// and negated forms, which it refers to and must not outlive.
struct BodyView {
  enum class Op { form, negated_form, max, min } op = Op::max;
  const FreeForm* form = nullptr;
  std::vector<BodyView> parts;  ///< of max and min; the max over none is -infinity
};

/// The whole body, with unions of unions taken as one, and a difference as the intersection with
/// the complements, -max(a, b) = min(-a, -b).
[[nodiscard]] BodyView view(const Body& body);

/// max or min over views, as above.
[[nodiscard]] BodyView combine(BodyView::Op op, std::vector<BodyView> parts);

/// The same value to the last bit as value(body, p), where p lies in the box at hand.
[[nodiscard]] double value(const BodyView& view, Vec3d p);

/// The view without the parts that decide nothing in the box: those below the greatest lower bound
/// of a max, or above the least upper bound of a min. With the range of the value over the box.
struct NarrowedBody {
  BodyView view;
  Interval range;
};
[[nodiscard]] NarrowedBody narrow(const BodyView& view, const Box& box);

}  // namespace pvol
