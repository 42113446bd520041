// Polynomials over [0, 1] in Bernstein form: where they are positive.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace pvol {

/// Part of [0, 1]; ends beyond it stand for "from before 0" and "to after 1".
struct Part01 {
  double a, b;
};

/// The open intervals in which b0 (1-s)^2 + 2 b1 s (1-s) + b2 s^2 is positive within [0, 1]; an end
/// at which it is positive itself counts as beyond.
struct Positive {
  std::array<Part01, 2> part{};
  int count = 0;
};

/// In x = 1 - s, y = s the polynomial is homogeneous, b0 x^2 + 2 b1 x y + b2 y^2, so a quadratic
/// that is linear, constant or square needs no case of its own. Each root is that of a polynomial
/// whose coefficients differ by a few ulp of the largest, since neither form of the solution
/// cancels (Kahan. On the Cost of Floating-Point Computation Without Extra-Precise Arithmetic.
/// 2004).
[[nodiscard]] inline Positive positive(double b0, double b1, double b2) {
  constexpr double kBefore = -1, kAfter = 2;
  const double d = b1 * b1 - b0 * b2;
  const double w = std::abs(b1) + std::sqrt(std::max(0.0, d));
  const auto low = [&] { return std::abs(b0) / (std::abs(b0) + w); };
  const auto high = [&] { return w / (w + std::abs(b2)); };
  if (b0 > 0 && b2 > 0) {
    if (b1 >= 0 || d <= 0) return {{Part01{kBefore, kAfter}}, 1};
    return {{Part01{kBefore, low()}, Part01{high(), kAfter}}, 2};
  }
  if (b0 > 0) return {{Part01{kBefore, b1 > 0 ? high() : low()}}, 1};
  if (b2 > 0) return {{Part01{b1 > 0 ? low() : high(), kAfter}}, 1};
  if (b1 > 0 && d > 0) return {{Part01{low(), high()}}, 1};
  return {};
}

/// A polynomial of degree four by its Bernstein coefficients.
using Quartic = std::array<double, 5>;

/// The polynomial over [0, u] and over [u, 1] (de Casteljau).
struct QuarticHalves {
  Quartic left, right;
};
[[nodiscard]] inline QuarticHalves split(const Quartic& c, double u) {
  QuarticHalves h;
  Quartic row = c;
  const double v = 1 - u;
  h.left[0] = row[0];
  h.right[4] = row[4];
  for (std::size_t step = 1; step < 5; ++step) {
    for (std::size_t i = 0; i + step < 5; ++i) row[i] = v * row[i] + u * row[i + 1];
    h.left[step] = row[0];
    h.right[4 - step] = row[4 - step];
  }
  return h;
}

/// The polynomial over [x, y], 0 <= x < y <= 1.
[[nodiscard]] inline Quartic restrict_to(const Quartic& c, double x, double y) {
  const Quartic left = y < 1 ? split(c, y).left : c;
  return x > 0 ? split(left, x / y).right : left;
}

/// The square of b0 (1-s)^2 + 2 b1 s (1-s) + b2 s^2.
[[nodiscard]] inline Quartic squared(double b0, double b1, double b2) {
  return {b0 * b0, b0 * b1, (b0 * b2 + 2 * (b1 * b1)) / 3, b1 * b2, b2 * b2};
}

/// The same polynomial as one of degree four.
[[nodiscard]] inline Quartic elevated(double b0, double b1, double b2) {
  return {b0, 0.5 * (b0 + b1), (b0 + 4 * b1 + b2) / 6, 0.5 * (b1 + b2), b2};
}

[[nodiscard]] inline int sign_changes(const Quartic& c) {
  int count = 0;
  for (std::size_t i = 0; i < 4; ++i) count += (c[i] >= 0) != (c[i + 1] >= 0);
  return count;
}

/// A point near the only root of a quartic with one sign change.
[[nodiscard]] inline double near_root(const Quartic& c) {
  const double a1 = 4 * (c[1] - c[0]), a2 = 6 * (c[2] - 2 * c[1] + c[0]);
  const double a3 = 4 * (c[3] - 3 * c[2] + 3 * c[1] - c[0]);
  const double a4 = c[4] - 4 * c[3] + 6 * c[2] - 4 * c[1] + c[0];
  const bool rises = c[4] >= 0;
  double lo = 0, hi = 1, x = c[0] / (c[0] - c[4]);
  constexpr double kStep = 0x1p-48;
  for (int i = 0; i < 60; ++i) {
    const double f = c[0] + x * (a1 + x * (a2 + x * (a3 + x * a4)));
    const double slope = a1 + x * (2 * a2 + x * (3 * a3 + x * (4 * a4)));
    ((f >= 0) == rises ? hi : lo) = x;
    double next = x - f / slope;
    if (!(next >= lo && next <= hi)) next = 0.5 * (lo + hi);
    const double step = std::abs(next - x);
    x = next;
    if (step < kStep) break;
  }
  return x;
}

/// Calls visit(a, b) for ascending intervals [a, b] of [x, y] that hold {c >= 0}, c over [0, 1]
/// seen from [x, y]; stops when it returns false, and then returns false itself. Only what de
/// Casteljau's coefficients, all of them negative, prove to lie outside is left out; besides {c >=
/// 0} the intervals hold points that are at most kIsolation of [x, y] away or at which c is
/// negative by rounding errors only.
inline constexpr double kIsolation = 0x1p-47;
template <class Visit>
bool visit_positive(const Quartic& c, double x, double y, const Visit& visit, int depth = 0) {
  constexpr int kDeepest = 47;  // kIsolation
  const int changes = sign_changes(c);
  if (changes == 0) return c[0] < 0 || visit(x, y);
  if (changes > 1) {
    if (depth == kDeepest) return visit(x, y);
    const QuarticHalves h = split(c, 0.5);
    const double middle = 0.5 * (x + y);
    return visit_positive(h.left, x, middle, visit, depth + 1) &&
           visit_positive(h.right, middle, y, visit, depth + 1);
  }
  const auto negative = [](const Quartic& q) { return *std::max_element(q.begin(), q.end()) < 0; };
  const double root = near_root(c);
  const bool rises = c[4] >= 0;
  for (double pad = kIsolation; pad < 1; pad *= 4) {
    const double end = rises ? root - pad : root + pad;
    if (!(end > 0 && end < 1)) break;
    const QuarticHalves h = split(c, end);
    if (!negative(rises ? h.left : h.right)) continue;
    const double s = x + end * (y - x);  // the caller's margin covers this rounding
    return rises ? visit(s, y) : visit(x, s);
  }
  return visit(x, y);
}

}  // namespace pvol
