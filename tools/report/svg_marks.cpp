// Where the axes of plots have marks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "report/svg.h"

namespace pvol::svg {
namespace {

/// Four significant digits at most, powers of ten from 10^5 on and below 10^-3.
std::string number(double v) {
  if (v < 0) return "−" + number(-v);
  const double size = v;
  if (size == 0 || (size >= 1e-3 && size < 1e5)) return fmt::format("{:.4g}", v);
  const int exponent = int(std::floor(std::log10(size) + 1e-12));
  const double mantissa = v / std::pow(10.0, exponent);
  std::string text = std::abs(mantissa - 1) > 1e-9 ? fmt::format("{:.3g}·", mantissa) : "";
  constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  text += exponent < 0 ? "10⁻" : "10";
  for (const char c : fmt::format("{}", std::abs(exponent))) text += kDigits[c - '0'];
  return text;
}

/// The smallest of 1, 2 and 5 times powers of ten that is at least v > 0.
double round_up(double v) {
  const double power = std::pow(10.0, std::floor(std::log10(v)));
  for (const double m : {1.0, 2.0, 5.0}) {
    if (m * power >= v * (1 - 1e-9)) return m * power;
  }
  return 10 * power;
}

std::vector<Mark> linear_marks(double lo, double hi, int count) {
  std::vector<Mark> m;
  const double step = round_up((hi - lo) / count);
  if (!(step > 0) || !std::isfinite(step)) return {{lo, number(lo)}};
  const double first = std::ceil(lo / step - 1e-9);
  for (int i = 0; i <= 3 * count && (first + i) * step <= hi + 1e-9 * step; ++i) {
    m.push_back({(first + i) * step, number((first + i) * step)});
  }
  return m;
}

std::vector<Mark> logarithmic_marks(double lo, double hi, int count) {
  std::vector<Mark> m;
  const int first = int(std::floor(std::log10(lo) + 1e-9)), last = int(std::ceil(std::log10(hi)));
  const int stride = std::max(1, (last - first + count - 1) / count);
  const bool between = 3 * (last - first) <= count + 2;
  for (int decade = first; decade <= last; decade += stride) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double at = factor * std::pow(10.0, decade);
      const bool in_range = at >= lo * (1 - 1e-9) && at <= hi * (1 + 1e-9);
      if (in_range && (factor == 1 || between)) m.push_back({at, number(at)});
    }
  }
  return m;
}

}  // namespace

std::vector<Mark> marks(double lo, double hi, bool logarithmic, int count) {
  return logarithmic ? logarithmic_marks(lo, hi, count) : linear_marks(lo, hi, count);
}

}  // namespace pvol::svg
