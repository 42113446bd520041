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

/// By entry, in each space.
using Tables = std::array<std::array<Rgb, kEntries>, names(ColorSpace{}).size()>;
Tables make_tables() {
  Tables tables;
  for (std::size_t i = 0; i < kEntries; ++i) {
    const double share = double(i) / (kEntries - 1);
    const Vec3d c = blackbody_chromaticity(1 / ((1 - share) / kHottest + share / kColdest));
    const Vec3d linear = rec709(c / c.y);
    for (const auto& named : names(ColorSpace{})) {
      const Vec3d there = conversion(ColorSpace::rec709, named.value).vector(linear);
      const Vec3d inside = max(there, Vec3d(0.0));
      tables[std::size_t(named.value)][i] =
          Rgb(inside / dot(inside, luminance_weights(named.value)));
    }
  }
  return tables;
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

Rgb blackbody_color(float kelvin, ColorSpace space) {
  static const Tables tables = make_tables();
  const auto& table = tables[std::size_t(space)];
  constexpr double kStart = 1 / kHottest, kSpan = 1 / kColdest - 1 / kHottest;
  const double t = std::clamp(double(kelvin), kColdest, kHottest);
  const double at = (1 / t - kStart) / kSpan * (kEntries - 1);
  const auto i = std::min(std::size_t(std::max(at, 0.0)), std::size_t(kEntries - 2));
  const float u = float(at - double(i));
  return table[i] * (1 - u) + table[i + 1] * u;
}

}  // namespace pvol
