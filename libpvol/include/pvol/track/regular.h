// Closed forms: along a ray, mu_t is a cubic in every cell, its optical depth a quartic.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pvol/track/field.h"

namespace pvol {

/// A cubic on [0, 1] by its Bernstein coefficients, none of them negative. Every sum below is one
/// of non-negative terms: relative errors are a few roundings.
struct BernsteinCubic {
  std::array<double, 4> b{};

  [[nodiscard]] double operator()(double x) const {
    const double y = 1 - x;
    return y * y * (y * b[0] + 3 * x * b[1]) + x * x * (3 * y * b[2] + x * b[3]);
  }

  /// The integral from 0 to x, a quartic whose coefficients are partial sums.
  [[nodiscard]] double integral(double x) const {
    const double y = 1 - x, b1 = b[0], b2 = b1 + b[1], b3 = b2 + b[2], b4 = b3 + b[3];
    return x / 4 * (y * y * (4 * y * b1 + 6 * x * b2) + x * x * (4 * y * b3 + x * b4));
  }

  /// An x with integral(x) = area but for rounding, for 0 <= area < integral(1): Newton's method,
  /// kept within a bracket that ends when no number is left in it.
  [[nodiscard]] double inverse_integral(double area) const {
    double lo = 0, hi = 1, x = area / integral(1);
    while (lo < x && x < hi) {
      const double excess = integral(x) - area;
      (excess < 0 ? lo : hi) = x;
      double next = x - excess / (*this)(x);
      if (next == x) break;
      if (!(lo < next && next < hi)) next = 0.5 * (lo + hi);
      x = next;
    }
    return std::clamp(x, 0.0, 1.0);
  }
};

namespace detail {

/// A trilinear function along the line from f0 to f1 in the unit cube. By polarisation its
/// Bernstein coefficients are means over its values where some coordinates are those of f0, the
/// others those of f1: convex combinations of the corners, all of them.
[[nodiscard]] inline BernsteinCubic along_line(const std::array<float, 8>& corners, Vec3d f0,
                                               Vec3d f1) {
  const auto lerp = [](double a, double b, double t) { return (1 - t) * a + t * b; };
  const auto c = [&](std::size_t i) { return double(corners[i]); };
  const auto at = [&](double x, double y, double z) {
    return lerp(lerp(lerp(c(0), c(1), z), lerp(c(2), c(3), z), y),
                lerp(lerp(c(4), c(5), z), lerp(c(6), c(7), z), y), x);
  };
  return {{at(f0.x, f0.y, f0.z),
           (at(f1.x, f0.y, f0.z) + at(f0.x, f1.y, f0.z) + at(f0.x, f0.y, f1.z)) / 3,
           (at(f0.x, f1.y, f1.z) + at(f1.x, f0.y, f1.z) + at(f1.x, f1.y, f0.z)) / 3,
           at(f1.x, f1.y, f1.z)}};
}

/// A stretch of a segment in which mu_t is one cubic.
struct Piece {
  double t0, length;  // world
  BernsteinCubic mu;  // over the piece
  [[nodiscard]] double optical_depth() const { return length * mu.integral(1); }
};

/// The line of a segment from place to place, in cells from the cell where it starts.
struct SegmentLine {
  LatticePoint from, to;
  Vec3d start, step;  // start + x step, 0 <= x <= 1

  template <class Segments>
  SegmentLine(const Segments& segments, const Segment& s)
      : from(segments.point(s.t0)),
        to(segments.point(s.t1)),
        start(vec3(from.frac)),
        step(Vec3d(vec3(to.cell - from.cell)) + Vec3d(vec3(to.frac)) - start) {}

  /// The nearest x above `after` at which the line crosses a plane where an axis is offset + an
  /// integer; 1 at most.
  [[nodiscard]] double next_crossing(double after, double offset) const {
    double nearest = 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (step[axis] == 0) continue;
      const double toward = step[axis] > 0 ? 1 : -1;
      const double at = toward * (start[axis] + after * step[axis] - offset);
      const auto crossing = [&](double plane) {
        return (toward * plane + offset - start[axis]) / step[axis];
      };
      double x = crossing(std::floor(at) + 1);
      // Rounding may put the plane ahead at or before `after`: then the one behind it is next.
      if (!(x > after)) x = crossing(std::floor(at) + 2);
      nearest = std::min(nearest, x);
    }
    return nearest;
  }

  /// The cell that holds the line at x, among those between the segment's ends.
  [[nodiscard]] Int4 cell_at(double x) const {
    const Vec3d p = start + step * x;
    const Int4 cell =
        from.cell + widen(Vec3i(int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))));
    return min(max(cell, min(from.cell, to.cell)), max(from.cell, to.cell));
  }

  /// The line at x, as an offset in a cell.
  [[nodiscard]] Vec3d offset_in(Int4 cell, double x) const {
    const Vec3d p = start + step * x - Vec3d(vec3(cell - from.cell));
    return max(min(p, Vec3d(1.0)), Vec3d(0.0));
  }
};

/// `visit(piece)` for all pieces of a segment in order, until it returns true: then the result is
/// true.
template <class Segments, class Field, class Count, class Visit>
[[nodiscard]] bool visit_pieces(const Segments& segments, const Segment& s, const Field& field,
                                Count& count, const Visit& visit) {
  constexpr bool kNearest = decltype(field.source)::kLookUp == LookUp::nearest;
  const SegmentLine line(segments, s);
  for (double x = 0; x < 1;) {
    const double end = line.next_crossing(x, kNearest ? 0.5 : 0);
    const Int4 cell = line.cell_at(0.5 * (x + end));
    count.lookup();
    const std::array<float, 8> corners = field.source.corners(s, cell);
    Piece piece{s.t0 + x * (s.t1 - s.t0), (end - x) * (s.t1 - s.t0), {}};
    if constexpr (kNearest) {
      const Vec3d f = line.offset_in(cell, 0.5 * (x + end));
      const int nearest = 4 * (f.x >= 0.5) + 2 * (f.y >= 0.5) + (f.z >= 0.5);
      piece.mu.b.fill(double(corners[std::size_t(nearest)]));
    } else {
      piece.mu = along_line(corners, line.offset_in(cell, x), line.offset_in(cell, end));
    }
    if (visit(piece)) return true;
    x = end;
  }
  return false;
}

}  // namespace detail

/// The optical depth along all segments, exact but for the rounding of positions to floats (T1.3),
/// on trilinear and nearest fields. Every cell crossed is a look-up.
template <class Segments, CellField Field, class Count>
[[nodiscard]] double optical_depth(Segments& segments, const Field& field, Count& count) {
  double sum = 0;
  while (const auto s = segments.next()) {
    count.segment();
    (void)detail::visit_pieces(segments, *s, field, count, [&](const detail::Piece& piece) {
      sum += piece.optical_depth();
      return false;
    });
  }
  return sum;
}

/// The distance at which the optical depth along the segments reaches `depth` >= 0, with the same
/// accuracy; nothing where it never does. Regular tracking (Amanatides and Woo 1987 for the cells;
/// Sutton et al. 1999 for the idea) with the quartic inverted in full precision (THEORY.md, T3.6).
template <class Segments, CellField Field, class Count>
[[nodiscard]] std::optional<double> regular_flight(Segments& segments, const Field& field,
                                                   double depth, Count& count) {
  double rest = depth, t = 0;
  const auto reaches = [&](const detail::Piece& piece) {
    const double all = piece.optical_depth();
    if (!(rest < all)) {
      rest -= all;
      return false;
    }
    t = piece.t0 + piece.length * piece.mu.inverse_integral(rest / piece.length);
    return true;
  };
  while (const auto s = segments.next()) {
    count.segment();
    if (detail::visit_pieces(segments, *s, field, count, reaches)) return t;
  }
  return std::nullopt;
}

}  // namespace pvol
