#include "pvol/volume/draine.h"

namespace pvol {
namespace {

/// 1 + alpha <cos^2>: the integral of p_g (1 + alpha cos^2).
double integral(double g, double alpha) { return 1 + alpha * (1 + 2 * g * g) / 3; }

/// A place on the way from the peak to its opposite, by the share v that p_g alone has within it.
struct Within {
  double one_minus_cos;
  double share;  ///< of p
  double slope;  ///< of it by v
};

/// Sums of positive powers of y, without differences of what is large, for any g (THEORY.md, T4.4).
Within within(double g, double alpha, double v) {
  const double a = 1 - g, y = 2 * a * v / (a + 2 * g * (1 - v)), s = a + g * y;
  const double c = 0.5 * y * (a + s), cosine = 1 - c;
  const double more = 0.5 * a * (1 + g) * y * y / s * (0.25 * y * (a + s / 3) - 1);
  const double all = integral(g, alpha);
  return {c, ((1 + alpha) * v + alpha * more) / all, (1 + alpha * cosine * cosine) / all};
}

}  // namespace

Draine::Draine(double g, double a) : lobe(g), alpha(a) {
  const double all = integral(g, alpha), size = std::abs(g),
               y = 2 / (1 - size + std::sqrt(1 + g * g));
  // The y at right angles to the peak, and the v that belongs to it.
  turn_share = within(size, alpha, 0.5 * (1 + size) * y / (1 - size + size * y)).share;
  flat = float(1 / all);
  squared = float(alpha / all);
}

double mean_cosine(const Draine& p) {
  const double g = p.lobe.mean_cosine;
  return g * (1 + p.alpha * (3 + 2 * g * g) / 5) / integral(g, p.alpha);
}

// The share rises ever less steeply up to right angles, and from there ever more: Newton's method
// from the end on the same side never passes the root, whatever alpha and g.
float one_minus_cos_of_share(const Draine& p, float u) {
  const double g = std::abs(p.lobe.mean_cosine), target = double(u);
  const double sign = target < p.turn_share ? 1 : -1;
  double v = sign > 0 ? 0 : 1;
  for (;;) {
    const Within at = within(g, p.alpha, v);
    const double step = (target - at.share) / at.slope;
    // Once rounding turns it back, or it is too short to tell in float, it has arrived.
    if (!(step * sign > 1e-13 * v)) return float(std::clamp(at.one_minus_cos, 0.0, 2.0));
    v = std::clamp(v + step, 0.0, 1.0);
  }
}

}  // namespace pvol
