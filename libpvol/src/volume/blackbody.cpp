#include "pvol/volume/blackbody.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pvol/math/observer.h"

namespace pvol {
namespace {

/// Temperatures are tabulated evenly in their reciprocals, by which colours change evenly.
constexpr double kColdest = 800, kHottest = 40'000;
constexpr int kEntries = 512;

Rgb color_of(double kelvin) {
  const Vec3d c = blackbody_chromaticity(kelvin);
  const Vec3d linear = rec709(c / c.y);  // of luminance 1
  const Vec3d inside = max(linear, Vec3d(0.0));
  return Rgb(inside / (0.2126 * inside.x + 0.7152 * inside.y + 0.0722 * inside.z));
}

using Table = std::array<Rgb, kEntries>;
Table make_table() {
  Table t;
  for (int i = 0; i < kEntries; ++i) {
    const double share = double(i) / (kEntries - 1);
    t[std::size_t(i)] = color_of(1 / ((1 - share) / kHottest + share / kColdest));
  }
  return t;
}

}  // namespace

Vec3d blackbody_chromaticity(double kelvin) {
  constexpr double kSecond = 1.438776877e7;  // second radiation constant, nm K
  Vec3d sum;
  for (std::size_t i = 0; i < kObserver.size(); ++i) {
    const double nm = kFirstNm + kStepNm * double(i);
    // Scaled by the radiance at 780 nm, so that nothing underflows.
    const double a = kSecond / (nm * kelvin), b = kSecond / (780 * kelvin);
    sum +=
        kObserver[i] * (std::exp(b - a) * std::pow(nm / 780, -5) * std::expm1(-b) / std::expm1(-a));
  }
  return sum / (sum.x + sum.y + sum.z);
}

Rgb blackbody_color(float kelvin) {
  static const Table table = make_table();
  constexpr double kStart = 1 / kHottest, kSpan = 1 / kColdest - 1 / kHottest;
  const double t = std::clamp(double(kelvin), kColdest, kHottest);
  const double at = (1 / t - kStart) / kSpan * (kEntries - 1);
  const auto i = std::min(std::size_t(std::max(at, 0.0)), std::size_t(kEntries - 2));
  const float u = float(at - double(i));
  return table[i] * (1 - u) + table[i + 1] * u;
}

}  // namespace pvol
