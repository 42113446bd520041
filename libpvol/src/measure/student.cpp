#include "pvol/measure/student.h"

#include <cmath>
#include <initializer_list>
#include <limits>

namespace pvol::measure {
namespace {

constexpr double kNormal = 1e8;  // degrees of freedom from which on the normal law is used

/// log Gamma(a + 1/2) - log Gamma(a): by Stirling's series where the difference of two large values
/// would lose digits.
double log_gamma_half_step(double a) {
  if (a < 1e3) return std::lgamma(a + 0.5) - std::lgamma(a);
  return 0.5 * std::log(a) - 1 / (8 * a) + 1 / (192 * a * a * a);  // DLMF 5.11.13
}

/// The continued fraction of the incomplete beta function (DLMF 8.17.22), evaluated forwards by the
/// method of Lentz; converges quickly for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;  // stands for 0 in a denominator
  constexpr int kMostTerms = 100'000;
  const auto keep = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1, d = 1 / keep(1 - (a + b) * x / (a + 1)), value = d;
  for (int i = 1; i < kMostTerms; ++i) {
    const double m = i;
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    for (const double term : {even, odd}) {
      d = 1 / keep(1 + term * d);
      c = keep(1 + term / c);
      value *= c * d;
    }
    if (std::abs(c * d - 1) < 4 * std::numeric_limits<double>::epsilon()) break;
  }
  return value;
}

}  // namespace

double student_p_value(double t, double dof) {
  t = std::abs(t);
  if (std::isnan(t) || std::isnan(dof)) return std::numeric_limits<double>::quiet_NaN();
  if (t == 0 || !(dof > 0)) return 1;  // without data nothing is far from 0
  if (std::isinf(t)) return 0;
  if (dof > kNormal) return std::erfc(t / std::sqrt(2.0));
  // I_x(dof / 2, 1/2) at x = dof / (dof + t^2), from whichever side converges (DLMF 8.17.4).
  const double a = dof / 2, b = 0.5, share = t / dof * t;
  const double x = 1 / (1 + share), y = share / (1 + share);
  const double log_scale =
      -a * std::log1p(share) + b * std::log(y) + log_gamma_half_step(a) - std::lgamma(b);
  if (x < (a + 1) / (a + b + 2)) return std::exp(log_scale) / a * beta_fraction(a, b, x);
  return 1 - std::exp(log_scale) / b * beta_fraction(b, a, y);
}

double student_quantile(double confidence, double dof) {
  if (!(confidence > 0)) return 0;
  const double tail = 1 - confidence;
  double low = 0, high = 1;
  while (student_p_value(high, dof) > tail) {
    low = high;
    high *= 2;
    if (std::isinf(high)) return high;
  }
  while (high - low > 1e-10 * high) {
    const double middle = 0.5 * (low + high);
    (student_p_value(middle, dof) > tail ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double sidak_p_value(double p, double count) {
  return count > 0 ? -std::expm1(std::log1p(-p) * count) : 1;
}

}  // namespace pvol::measure
