#include "pvol/form/roots.h"

namespace pvol {
namespace {

[[nodiscard]] Quartic derivative(const Quartic& c) {
  return {c[1], 2 * c[2], 3 * c[3], 4 * c[4], 0};
}

/// The root between places at which the signs differ.
[[nodiscard]] double bracketed(const Quartic& c, const Quartic& slope, double lo, double hi) {
  const bool rises = value(c, hi) > 0;
  double s = 0.5 * (lo + hi);
  // A Newton step that would leave the bracket is a bisection: 1100 halve any interval of doubles
  // down to two neighbours, and a few steps do where the slope is of any use.
  for (int step = 0; step < 1100; ++step) {
    const double v = value(c, s);
    if (v == 0) return s;
    ((v > 0) == rises ? hi : lo) = s;
    double next = s - v / value(slope, s);
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (!(next > lo && next < hi) || next == s) return s;
    s = next;
  }
  return s;
}

}  // namespace

Roots sign_changes(const Quartic& c, double lo, double hi) {
  const Quartic slope = derivative(c);
  const bool quadratic = c[3] == 0 && c[4] == 0;
  Roots cuts;
  if (!quadratic) {
    cuts = sign_changes(slope, lo, hi);
  } else if (c[2] != 0) {
    cuts.add(-0.5 * c[1] / c[2]);
  }
  Roots r;
  double from = lo, sign = 0;  // a value on this side of the next root
  bool touched = false;        // the value at `from` is 0
  const auto search = [&](double to) {
    const double v = value(c, to);
    if (v != 0 && sign * v < 0) r.add(touched ? from : bracketed(c, slope, from, to));
    if (v != 0) sign = v > 0 ? 1 : -1;
    touched = v == 0;
    from = to;
  };
  search(lo);
  for (const double s : cuts.all()) {
    if (s > from && s < hi) search(s);
  }
  search(hi);
  return r;
}

}  // namespace pvol
