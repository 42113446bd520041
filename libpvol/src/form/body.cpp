#include "pvol/form/body.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace pvol {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Interval kLowest{-kInfinity, -kInfinity}, kHighest{kInfinity, kInfinity};

Box common(const Box& a, const Box& b) {
  const Box box{max(a.lo, b.lo), min(a.hi, b.hi)};
  return box.empty() ? Box{} : box;
}

BodyView view(const Body& body, bool negated) {
  using Op = BodyView::Op;
  if (body.op == BodyOp::form) return {negated ? Op::negated_form : Op::form, &body.form, {}};
  std::vector<BodyView> parts;
  for (const Body& part : body.parts) {
    const bool removed = body.op == BodyOp::difference && &part != &body.parts.front();
    parts.push_back(view(part, negated != removed));
  }
  return combine((body.op == BodyOp::join) != negated ? Op::max : Op::min, std::move(parts));
}

}  // namespace

double value(const Body& body, Vec3d p) {
  if (body.op == BodyOp::form) return value(body.form, p);
  double result = value(body.parts.front(), p);
  for (std::size_t i = 1; i < body.parts.size(); ++i) {
    const double part = value(body.parts[i], p);
    result = body.op == BodyOp::join           ? std::max(result, part)
             : body.op == BodyOp::intersection ? std::min(result, part)
                                               : std::min(result, -part);
  }
  return result;
}

Interval range(const Body& body, const Box& box) { return narrow(view(body), box).range; }

Box bounds(const Body& body, double level) {
  if (body.op == BodyOp::form) return bounds(body.form, level);
  Box box = bounds(body.parts.front(), level);
  if (body.op == BodyOp::difference) return box;
  for (std::size_t i = 1; i < body.parts.size(); ++i) {
    const Box part = bounds(body.parts[i], level);
    box = body.op == BodyOp::join ? join(box, part) : common(box, part);
  }
  return box;
}

Body operator*(double k, const Body& body) {
  Body scaled = body;
  if (body.op == BodyOp::form) scaled.form = k * body.form;
  for (Body& part : scaled.parts) part = k * part;
  return scaled;
}

Body transform(const Affine& map, const Body& body) {
  Body moved = body;
  if (body.op == BodyOp::form) moved.form = transform(map, body.form);
  for (Body& part : moved.parts) part = transform(map, part);
  return moved;
}

std::size_t count_quadrics(const Body& body) {
  std::size_t count = body.op == BodyOp::form ? count_quadrics(body.form) : 0;
  for (const Body& part : body.parts) count += count_quadrics(part);
  return count;
}

int depth(const Body& body) {
  int deepest = 0;
  for (const Body& part : body.parts) deepest = std::max(deepest, 1 + depth(part));
  return deepest;
}

BodyView view(const Body& body) { return view(body, false); }

BodyView combine(BodyView::Op op, std::vector<BodyView> parts) {
  if (parts.size() == 1) return std::move(parts.front());
  BodyView result{op, nullptr, {}};
  result.parts.reserve(parts.size());
  for (BodyView& part : parts) {
    if (part.op == op) {
      std::move(part.parts.begin(), part.parts.end(), std::back_inserter(result.parts));
    } else {
      result.parts.push_back(std::move(part));
    }
  }
  return result;
}

double value(const BodyView& view, Vec3d p) {
  switch (view.op) {
    case BodyView::Op::form:
      return value(*view.form, p);
    case BodyView::Op::negated_form:
      return -value(*view.form, p);
    case BodyView::Op::max: {
      double most = -kInfinity;
      for (const BodyView& part : view.parts) most = std::max(most, value(part, p));
      return most;
    }
    case BodyView::Op::min:
      break;
  }
  double least = kInfinity;
  for (const BodyView& part : view.parts) least = std::min(least, value(part, p));
  return least;
}

NarrowedBody narrow(const BodyView& view, const Box& box) {
  if (view.op == BodyView::Op::form) return {view, range(*view.form, box)};
  if (view.op == BodyView::Op::negated_form) return {view, -range(*view.form, box)};
  const bool is_max = view.op == BodyView::Op::max;
  Interval all = is_max ? kLowest : kHighest;
  std::vector<NarrowedBody> narrowed;
  narrowed.reserve(view.parts.size());
  for (const BodyView& part : view.parts) {
    narrowed.push_back(narrow(part, box));
    all = is_max ? max(all, narrowed.back().range) : min(all, narrowed.back().range);
  }
  std::vector<BodyView> kept;
  for (NarrowedBody& part : narrowed) {
    const bool matters = is_max ? part.range.hi >= all.lo : part.range.lo <= all.hi;
    if (matters) kept.push_back(std::move(part.view));
  }
  return {combine(view.op, std::move(kept)), all};
}

}  // namespace pvol
