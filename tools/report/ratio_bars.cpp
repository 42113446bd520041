#include "report/ratio_bars.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "report/html.h"
#include "report/svg.h"

namespace pvol::svg {
namespace {

constexpr double kWidth = 720, kLine = 22, kTop = 46;
constexpr double kNames = 270, kValues = 62;  // columns to the left and right of the bars

std::string number(double v, const char* format = "%.1f") {
  char text[32];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

std::string text_at(double x, double y, const char* anchor, const std::string& text,
                    const char* more = "") {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\"" +
         more + ">" + html::escape(text) + "</text>\n";
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
  std::string out = "<g><title>" + html::escape(b.label) + ": " + number(b.ratio.value, "%.3g") +
                    ", " + number(b.ratio.low, "%.3g") + " to " + number(b.ratio.high, "%.3g") +
                    "</title>\n";
  out += text_at(kNames - 8, middle + 4.5, "end", shortened(b.label),
                 b.faint ? " class=\"faint\"" : "");
  out += "<rect x=\"" + number(std::min(x, one)) + "\" y=\"" + number(y + 4) + "\" width=\"" +
         number(std::max(0.5, std::abs(x - one))) + "\" height=\"" + number(kLine - 8) +
         "\" style=\"fill:var(--c" + (x < one ? "2" : "1") + ")\" fill-opacity=\"" +
         (b.faint ? "0.45" : "0.85") + "\"/>\n";
  out += "<path d=\"M" + number(low) + " " + number(middle) + "H" + number(high) +
         "\" style=\"stroke:var(--ink);stroke-width:1.5\"/>\n";
  return out + text_at(kWidth - 4, middle + 4.5, "end", number(b.ratio.value, "%.3g")) + "</g>\n";
}

}  // namespace

std::string draw_ratios(const std::string& title, std::span<const RatioBar> bars) {
  const Places axis(bars);
  const double bottom = kTop + kLine * double(bars.size());
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 " +
                    number(kWidth) + " " + number(bottom + 6) + "\" aria-label=\"" +
                    html::escape(title) + "\">\n";
  out += text_at(4, 16, "start", title, " font-weight=\"600\"");
  for (const Mark& m : marks(axis.lo, axis.hi, true, 6)) {
    out += "<path class=\"grid\" d=\"M" + number(axis(m.at)) + " " + number(kTop) + "V" +
           number(bottom) + "\"/>\n";
    out += text_at(axis(m.at), kTop - 6, "middle", m.text, " class=\"faint\"");
  }
  for (std::size_t i = 0; i < bars.size(); ++i) {
    out += draw_bar(bars[i], axis, kTop + kLine * double(i));
  }
  out += "<path class=\"axis\" d=\"M" + number(axis(1)) + " " + number(kTop) + "V" +
         number(bottom) + "\"/>\n";
  return out + "</svg>\n";
}

}  // namespace pvol::svg
