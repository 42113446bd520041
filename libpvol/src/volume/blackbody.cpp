#include "pvol/volume/blackbody.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pvol {
namespace {

/// The CIE 1931 standard observer, from 380 nm in steps of 10 nm.
constexpr double kFirst = 380, kStep = 10;  // nm
constexpr std::array<Vec3d, 41> kObserver{{
    {0.0014, 0.0000, 0.0065}, {0.0042, 0.0001, 0.0201}, {0.0143, 0.0004, 0.0679},
    {0.0435, 0.0012, 0.2074}, {0.1344, 0.0040, 0.6456}, {0.2839, 0.0116, 1.3856},
    {0.3483, 0.0230, 1.7471}, {0.3362, 0.0380, 1.7721}, {0.2908, 0.0600, 1.6692},
    {0.1954, 0.0910, 1.2876}, {0.0956, 0.1390, 0.8130}, {0.0320, 0.2080, 0.4652},
    {0.0049, 0.3230, 0.2720}, {0.0093, 0.5030, 0.1582}, {0.0633, 0.7100, 0.0782},
    {0.1655, 0.8620, 0.0422}, {0.2904, 0.9540, 0.0203}, {0.4334, 0.9950, 0.0087},
    {0.5945, 0.9950, 0.0039}, {0.7621, 0.9520, 0.0021}, {0.9163, 0.8700, 0.0017},
    {1.0263, 0.7570, 0.0011}, {1.0622, 0.6310, 0.0008}, {1.0026, 0.5030, 0.0003},
    {0.8544, 0.3810, 0.0002}, {0.6424, 0.2650, 0.0000}, {0.4479, 0.1750, 0.0000},
    {0.2835, 0.1070, 0.0000}, {0.1649, 0.0610, 0.0000}, {0.0874, 0.0320, 0.0000},
    {0.0468, 0.0170, 0.0000}, {0.0227, 0.0082, 0.0000}, {0.0114, 0.0041, 0.0000},
    {0.0058, 0.0021, 0.0000}, {0.0029, 0.0010, 0.0000}, {0.0014, 0.0005, 0.0000},
    {0.0007, 0.0002, 0.0000}, {0.0003, 0.0001, 0.0000}, {0.0002, 0.0001, 0.0000},
    {0.0001, 0.0000, 0.0000}, {0.0000, 0.0000, 0.0000},
}};

/// Temperatures are tabulated evenly in their reciprocals, by which colours change evenly.
constexpr double kColdest = 800, kHottest = 40'000;
constexpr int kEntries = 512;

Rgb color_of(double kelvin) {
  const Vec3d c = blackbody_chromaticity(kelvin);
  const double x = c.x / c.y, z = c.z / c.y;  // of luminance 1
  const Vec3d linear{3.2404542 * x - 1.5371385 - 0.4985314 * z,
                     -0.9692660 * x + 1.8760108 + 0.0415560 * z,
                     0.0556434 * x - 0.2040259 + 1.0572252 * z};
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
    const double nm = kFirst + kStep * double(i);
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
