// Rays and axis-aligned boxes in double precision.
#pragma once

#include <limits>
#include <optional>

#include "pvol/math/affine.h"

namespace pvol {

/// Points o + t d. The direction need not be of unit length: the unit of t is the caller's.
struct Ray {
  Vec3d o, d;
  [[nodiscard]] Vec3d at(double t) const { return o + d * t; }
};

/// Closed box [lo, hi]; empty where lo > hi on some axis (so by default).
struct Box {
  Vec3d lo{std::numeric_limits<double>::infinity()};
  Vec3d hi{-std::numeric_limits<double>::infinity()};

  [[nodiscard]] bool empty() const { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
  [[nodiscard]] Vec3d centre() const { return (lo + hi) * 0.5; }
  [[nodiscard]] Vec3d extent() const { return hi - lo; }
  [[nodiscard]] bool contains(Vec3d p) const {
    return p.x >= lo.x && p.x <= hi.x && p.y >= lo.y && p.y <= hi.y && p.z >= lo.z && p.z <= hi.z;
  }
  friend bool operator==(const Box&, const Box&) = default;
};

/// Corner k, 0 to 7: its bits say along which axes it is at the high end, x first.
[[nodiscard]] inline Vec3d corner(const Box& b, unsigned k) {
  return {k & 1 ? b.hi.x : b.lo.x, k & 2 ? b.hi.y : b.lo.y, k & 4 ? b.hi.z : b.lo.z};
}

[[nodiscard]] inline Box extend(Box b, Vec3d p) { return {min(b.lo, p), max(b.hi, p)}; }
/// Around both; either may be empty.
[[nodiscard]] inline Box join(const Box& a, const Box& b) {
  if (a.empty()) return b;
  return b.empty() ? a : Box{min(a.lo, b.lo), max(a.hi, b.hi)};
}

/// The box around the image of `b` under `a`; empty where `b` is.
[[nodiscard]] inline Box transform(const Affine& a, const Box& b) {
  Box r;
  for (unsigned k = 0; k < 8 && !b.empty(); ++k) r = extend(r, a.point(corner(b, k)));
  return r;
}

struct Span {
  double t0, t1;
};

/// The part of the ray with t in [t0, t1] inside the box, or nothing; a single point is nothing.
/// Parallel to a face it is inside where its origin lies in the closed slab; -0.0 is like +0.0. An
/// end is off by a few ulps of the largest coordinate, over the direction's component.
[[nodiscard]] inline std::optional<Span> intersect(const Box& b, const Ray& r, double t0,
                                                   double t1) {
  for (int axis = 0; axis < 3; ++axis) {
    if (r.d[axis] == 0) {
      if (r.o[axis] < b.lo[axis] || r.o[axis] > b.hi[axis]) return std::nullopt;
      continue;
    }
    // By size: to branch by the direction's sign takes longer than both quotients.
    const double lo = (b.lo[axis] - r.o[axis]) / r.d[axis];
    const double hi = (b.hi[axis] - r.o[axis]) / r.d[axis];
    t0 = std::max(t0, std::min(lo, hi));
    t1 = std::min(t1, std::max(lo, hi));
  }
  return t0 < t1 && !b.empty() ? std::optional(Span{t0, t1}) : std::nullopt;
}

}  // namespace pvol
