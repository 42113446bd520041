#include "report/colour_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html.h"
#include "report/svg.h"

namespace pvol::cli {
namespace {

constexpr Srgb kUnknown{255, 0, 255};

/// Between colours at equal distances, linear in their bytes.
template <std::size_t kCount>
Srgb between(const std::array<Srgb, kCount>& stops, double t) {
  const double at = std::clamp(t, 0.0, 1.0) * double(kCount - 1);
  const auto i = std::min(std::size_t(at), kCount - 2);
  const double f = at - double(i);
  Srgb c;
  for (std::size_t k = 0; k < 3; ++k) {
    c[k] = std::uint8_t(std::lround(double(stops[i][k]) * (1 - f) + double(stops[i + 1][k]) * f));
  }
  return c;
}

std::string hex(Srgb c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

}  // namespace

Srgb colour_at(ColourMap map, double t) {
  constexpr std::array<Srgb, 5> kDiverging{
      {{0, 62, 108}, {74, 150, 205}, {246, 246, 244}, {226, 128, 52}, {132, 52, 0}}};
  constexpr std::array<Srgb, 5> kSequential{
      {{0, 32, 77}, {66, 77, 108}, {124, 123, 120}, {188, 174, 108}, {255, 234, 70}}};
  if (std::isnan(t)) return kUnknown;
  return map == ColourMap::diverging ? between(kDiverging, t) : between(kSequential, t);
}

formats::Picture map_colours(std::span<const double> values, int width, ColourMap map, double lo,
                             double hi) {
  formats::Picture p;
  p.width = width, p.height = int(values.size() / std::size_t(width));
  p.rgb.reserve(3 * values.size());
  for (const double v : values) {
    const Srgb c = colour_at(map, (v - lo) / (hi - lo));
    p.rgb.insert(p.rgb.end(), c.begin(), c.end());
  }
  return p;
}

std::string colour_bar(ColourMap map, double lo, double hi, const std::string& label) {
  constexpr int kSteps = 64, kWidth = 360, kLeft = 24, kLength = kWidth - 2 * kLeft;
  std::string out =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"bar\" role=\"img\" viewBox=\"0 0 360 "
      "52\">";
  for (int i = 0; i < kSteps; ++i) {
    out += fmt::format("<rect x=\"{:.2f}\" y=\"20\" width=\"{:.2f}\" height=\"12\" fill=\"{}\"/>",
                       kLeft + double(kLength) * i / kSteps, double(kLength) / kSteps + 0.3,
                       hex(colour_at(map, (i + 0.5) / kSteps)));
  }
  out += fmt::format("<text x=\"{}\" y=\"13\">{}</text>", kLeft, html::escape(label));
  for (const svg::Mark& m : svg::marks(lo, hi, false, 6)) {
    out +=
        fmt::format("<text class=\"faint\" x=\"{:.2f}\" y=\"47\" text-anchor=\"middle\">{}</text>",
                    kLeft + kLength * (m.at - lo) / (hi - lo), m.text);
  }
  return out + "</svg>\n";
}

}  // namespace pvol::cli
