#include "report/ratio_bars.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html.h"
#include "report/svg.h"

namespace pvol::svg {
namespace {

constexpr double kWidth = 720, kLine = 22, kTop = 46;
constexpr double kNames = 270, kValues = 62;  // columns to the left and right of the bars

std::string text_at(double x, double y, const char* anchor, const std::string& text,
                    const char* more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, more, html::escape(text));
}

/// Longer names would run into the bars; the tooltip has all of it.
std::string shortened(const std::string& name) {
  constexpr std::size_t kMost = 38;
  return name.size() <= kMost ? name : name.substr(0, kMost - 1) + "\u2026";
}

/// Positions of ratios on the axis.
struct Places {
  double lo = 0.8, hi = 1.25;

  explicit Places(std::span<const RatioBar> bars) {
    for (const RatioBar& b : bars) {
      lo = std::min(lo, b.ratio.low), hi = std::max(hi, b.ratio.high);
    }
    lo /= 1.05, hi *= 1.05;
  }
  [[nodiscard]] double operator()(double v) const {
    return kNames + std::log(v / lo) / std::log(hi / lo) * (kWidth - kNames - kValues);
  }
};

std::string draw_bar(const RatioBar& b, const Places& axis, double y) {
  const double x = axis(b.ratio.value), one = axis(1);
  const double low = axis(b.ratio.low), high = axis(b.ratio.high), middle = y + kLine / 2;
  std::string out = fmt::format("<g><title>{}: {:.3g}, {:.3g} to {:.3g}</title>\n",
                                html::escape(b.label), b.ratio.value, b.ratio.low, b.ratio.high);
  out += text_at(kNames - 8, middle + 4.5, "end", shortened(b.label),
                 b.faint ? " class=\"faint\"" : "");
  out += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
      "style=\"fill:var(--c{})\" fill-opacity=\"{}\"/>\n",
      std::min(x, one), y + 4, std::max(0.5, std::abs(x - one)), kLine - 8, x < one ? 2 : 1,
      b.faint ? "0.45" : "0.85");
  out += fmt::format(
      "<path d=\"M{:.1f} {:.1f}H{:.1f}\" style=\"stroke:var(--ink);stroke-width:1.5\"/>\n", low,
      middle, high);
  return out + text_at(kWidth - 4, middle + 4.5, "end", fmt::format("{:.3g}", b.ratio.value)) +
         "</g>\n";
}

}  // namespace

std::string draw_ratios(const std::string& title, std::span<const RatioBar> bars) {
  const Places axis(bars);
  const double bottom = kTop + kLine * double(bars.size());
  const auto rule = [&](const char* kind, double x) {
    return fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>\n", kind, x, kTop, bottom);
  };
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {:.1f} {:.1f}\" "
      "aria-label=\"{}\">\n",
      kWidth, bottom + 6, html::escape(title));
  out += text_at(4, 16, "start", title, " font-weight=\"600\"");
  for (const Mark& m : marks(axis.lo, axis.hi, true, 6)) {
    out += rule("grid", axis(m.at));
    out += text_at(axis(m.at), kTop - 6, "middle", m.text, " class=\"faint\"");
  }
  for (std::size_t i = 0; i < bars.size(); ++i) {
    out += draw_bar(bars[i], axis, kTop + kLine * double(i));
  }
  return out + rule("axis", axis(1)) + "</svg>\n";
}

}  // namespace pvol::svg
