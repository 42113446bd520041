#include "report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "report/html.h"

namespace pvol::svg {
namespace {

constexpr double kWidth = 560, kHeight = 360;  // of a plot, in its own units
constexpr double kLeft = 62, kRight = 16, kBottom = 46;
constexpr double kLine = 17;      // of text
constexpr double kGlyph = 6.8;    // mean width of a letter at 13 px
constexpr double kMarker = 4;     // radius
constexpr double kMargin = 0.04;  // free space around what is drawn, of the axis
constexpr int kColours = 8;

/// Letters, not bytes.
double text_width(const std::string& s) {
  const auto letters = std::count_if(s.begin(), s.end(), [](char c) { return (c & 0xC0) != 0x80; });
  return kGlyph * double(letters);
}

std::string variable(int colour) { return fmt::format("var(--c{})", colour % kColours); }

std::string text(double x, double y, const char* anchor, const std::string& what,
                 const std::string& attributes = "") {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, attributes, html::escape(what));
}

/// Of the grid.
std::string line(double x0, double y0, double x1, double y1) {
  constexpr const char* kLineElement =
      "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" class=\"grid\"/>\n";
  return fmt::format(kLineElement, x0, y0, x1, y1);
}

/// An axis with its range chosen.
struct Scale {
  bool logarithmic = false;
  double lo = 0, hi = 1;    // of values
  double from = 0, to = 1;  // of the drawing

  [[nodiscard]] bool holds(double v) const { return std::isfinite(v) && (!logarithmic || v > 0); }
  [[nodiscard]] double share(double v) const {
    return logarithmic ? std::log(v / lo) / std::log(hi / lo) : (v - lo) / (hi - lo);
  }
  [[nodiscard]] double operator()(double v) const { return from + share(v) * (to - from); }
  [[nodiscard]] double clamped(double v) const {
    return from + (holds(v) ? std::clamp(share(v), 0.0, 1.0) : 0.0) * (to - from);
  }
};

/// The range of an axis: what is asked for, else that of the values and a little more.
Scale make_scale(const Axis& axis, const std::vector<double>& values, bool from_zero) {
  Scale s;
  s.logarithmic = axis.logarithmic;
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (const double v : values) {
    if (s.holds(v)) lo = std::min(lo, v), hi = std::max(hi, v);
  }
  if (!(lo <= hi)) lo = axis.logarithmic ? 1 : 0, hi = axis.logarithmic ? 10 : 1;
  if (axis.logarithmic) {
    if (hi < 1.5 * lo) lo /= 1.5, hi *= 1.5;
    const double margin = std::pow(hi / lo, kMargin);
    s.lo = axis.lo.value_or(lo / margin), s.hi = axis.hi.value_or(hi * margin);
  } else {
    if (from_zero) lo = std::min(lo, 0.0), hi = std::max(hi, 0.0);
    if (hi == lo) lo -= lo == 0 ? 0 : 0.1 * std::abs(lo), hi += hi == 0 ? 1 : 0.1 * std::abs(hi);
    const double margin = kMargin * (hi - lo);
    const bool ground = from_zero && lo == 0;
    s.lo = axis.lo.value_or(ground ? 0 : lo - margin), s.hi = axis.hi.value_or(hi + margin);
  }
  return s;
}

struct Rectangle {
  double x0, y0, x1, y1;
};

bool overlap(const Rectangle& a, const Rectangle& b) {
  return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

/// The drawing of one plot.
class Canvas {
 public:
  explicit Canvas(const Plot& plot) : plot_(plot) {
    choose_colours();
    const double top = draw_title_and_legend();
    choose_scales(top);
    draw_axes();
    for (std::size_t i = 0; i < plot_.bars.size(); ++i) draw_bars(plot_.bars[i], bar_colours_[i]);
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      draw_series(plot_.series[i], series_colours_[i]);
    }
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      draw_labels(plot_.series[i], series_colours_[i]);
    }
  }

  [[nodiscard]] std::string result() const {
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {:.2f} {:.2f}\" "
        "aria-label=\"{}\">\n{}</svg>\n",
        kWidth, kHeight, html::escape(plot_.title), out_);
  }

 private:
  void choose_colours() {
    int next = 0;
    for (const Bars& b : plot_.bars) bar_colours_.push_back(b.colour.value_or(next++));
    for (const Series& s : plot_.series) series_colours_.push_back(s.colour.value_or(next++));
  }

  /// Returns the ordinate below them.
  double draw_title_and_legend() {
    double x = kLeft, y = kLine;
    if (!plot_.title.empty()) {
      out_ += text(kLeft, y - 3, "start", plot_.title, " font-weight=\"600\"");
      y += kLine;
    }
    const double first = y;
    const auto entry = [&](const std::string& name, int colour, const char* shape, bool dashed) {
      if (name.empty()) return;
      const double width = 24 + text_width(name) + 14;
      if (x > kLeft && x + width > kWidth - kRight) x = kLeft, y += kLine;
      put("<path d=\"M{0:.2f} {1:.2f}{2}\" style=\"stroke:{3};fill:{3};stroke-width:2{4}\"/>\n", x,
          y - 8, shape, variable(colour), dashed ? ";stroke-dasharray:4 3" : "");
      out_ += text(x + 22, y - 4, "start", name, " class=\"faint\"");
      x += width;
    };
    for (std::size_t i = 0; i < plot_.bars.size(); ++i) {
      entry(plot_.bars[i].name, bar_colours_[i], "m3 -4h9v9h-9z", false);
    }
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const bool points = plot_.series[i].style == Style::points;
      entry(plot_.series[i].name, series_colours_[i],
            points ? "m4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z" : "h16", plot_.series[i].dashed);
    }
    return (x > kLeft || y > first ? y : y - kLine) + 8;
  }

  void choose_scales(double top) {
    std::vector<double> x, y;
    for (const Series& s : plot_.series) {
      for (const Point& p : s.points) {
        x.push_back(p.x);
        for (const double v : {p.y - p.error, p.y, p.y + p.error}) y.push_back(v);
      }
    }
    for (const Bars& b : plot_.bars) {
      for (const Bar& bar : b.bars) {
        x.push_back(bar.x0), x.push_back(bar.x1), y.push_back(bar.y);
      }
    }
    x_ = make_scale(plot_.x, x, false);
    y_ = make_scale(plot_.y, y, !plot_.bars.empty());
    x_.from = kLeft, x_.to = kWidth - kRight;
    y_.from = kHeight - kBottom, y_.to = top + kLine;
  }

  void draw_axes() {
    for (const Mark& m : marks(x_.lo, x_.hi, x_.logarithmic, 7)) {
      out_ += line(x_(m.at), y_.from, x_(m.at), y_.to);
      out_ += text(x_(m.at), y_.from + kLine, "middle", m.text, " class=\"faint\"");
    }
    for (const Mark& m : marks(y_.lo, y_.hi, y_.logarithmic, 6)) {
      out_ += line(x_.from, y_(m.at), x_.to, y_(m.at));
      out_ += text(x_.from - 7, y_(m.at) + 4.5, "end", m.text, " class=\"faint\"");
    }
    put("<path class=\"axis\" d=\"M{:.2f} {:.2f}V{:.2f}H{:.2f}\"/>\n", x_.from, y_.to, y_.from,
        x_.to);
    out_ += text((x_.from + x_.to) / 2, kHeight - 8, "middle", plot_.x.label);
    out_ += text(6, y_.to - 11, "start", plot_.y.label);
  }

  void draw_bars(const Bars& bars, int colour) {
    for (const Bar& b : bars.bars) {
      if (!x_.holds(b.x0) || !x_.holds(b.x1) || !y_.holds(b.y)) continue;
      const double x0 = x_.clamped(b.x0), x1 = x_.clamped(b.x1);
      const double ground = y_.logarithmic ? y_.from : y_.clamped(0), y = y_.clamped(b.y);
      put("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" style=\"fill:{}\" "
          "fill-opacity=\"{}\"><title>{:.6g} to {:.6g}: {:.6g}</title></rect>\n",
          x0, std::min(y, ground), std::max(0.5, x1 - x0 - 0.5), std::abs(ground - y),
          variable(colour), plot_.bars.size() > 1 ? "0.55" : "0.85", b.x0, b.x1, b.y);
    }
  }

  [[nodiscard]] bool is_drawn(const Point& p) const {
    return x_.holds(p.x) && y_.holds(p.y) && x_.share(p.x) > -0.01 && x_.share(p.x) < 1.01 &&
           y_.share(p.y) > -0.01 && y_.share(p.y) < 1.01;
  }

  void draw_series(const Series& s, int colour) {
    std::string path;
    for (const Point& p : s.points) {
      if (!is_drawn(p)) continue;
      const bool stair = s.style == Style::steps && !path.empty();
      path += path.empty() ? 'M' : stair ? 'H' : 'L';
      path += fmt::format("{:.2f}{}{:.2f}", x_(p.x), stair ? 'V' : ' ', y_(p.y));
    }
    if (s.style != Style::points && !path.empty()) {
      put("<path d=\"{}\" fill=\"none\" style=\"stroke:{};stroke-width:2{}\"/>\n", path,
          variable(colour), s.dashed ? ";stroke-dasharray:5 4" : "");
    }
    if (s.style == Style::steps || s.style == Style::curve) return;
    for (const Point& p : s.points) draw_point(p, colour);
  }

  void draw_point(const Point& p, int colour) {
    if (!is_drawn(p)) return;
    const double x = x_(p.x), y = y_(p.y);
    if (p.error > 0) {
      const double low = y_.clamped(p.y - p.error), high = y_.clamped(p.y + p.error);
      put("<path d=\"M{0:.2f} {1:.2f}V{2:.2f}m-4 0h8M{3:.2f} {1:.2f}h8\" fill=\"none\" "
          "style=\"stroke:{4};stroke-width:1.3\"/>\n",
          x, low, high, x - 4, variable(colour));
    }
    put("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" style=\"fill:{}\"><title>{}{:.6g}, "
        "{:.6g}{}</title></circle>\n",
        x, y, kMarker, variable(colour), html::escape(p.label.empty() ? "" : p.label + ": "), p.x,
        p.y, p.error > 0 ? fmt::format(" ± {:.6g}", p.error) : "");
    taken_.push_back({x - kMarker, y - kMarker, x + kMarker, y + kMarker});
  }

  void draw_labels(const Series& s, int colour) {
    for (const Point& p : s.points) {
      if (!p.label.empty() && is_drawn(p)) draw_label(p, colour);
    }
  }

  /// Tries places around the point, near ones first.
  void draw_label(const Point& p, int colour) {
    const double width = text_width(p.label), x = x_(p.x), y = y_(p.y);
    for (const double away : {4.0, 14.0, 26.0, 40.0}) {
      const double right = x + kMarker + away, left = x - kMarker - away - width;
      const double middle = x - width / 2;
      const double above = y - kMarker - away, below = y + kMarker + away + 10;
      const double level = y + 4.5;
      const std::pair<double, double> places[] = {{right, level}, {right, above},  {middle, above},
                                                  {right, below}, {middle, below}, {left, above},
                                                  {left, level},  {left, below}};
      for (const auto& [tx, ty] : places) {
        const Rectangle box{tx - 1, ty - 11, tx + width + 1, ty + 3};
        const bool inside =
            box.x0 > x_.from && box.x1 < kWidth && box.y0 > y_.to - 4 && box.y1 < y_.from;
        if (!inside || std::any_of(taken_.begin(), taken_.end(),
                                   [&](const Rectangle& r) { return overlap(r, box); })) {
          continue;
        }
        if (away > 4) {
          const double end_x = std::clamp(x, box.x0, box.x1), end_y = ty > y ? box.y0 : box.y1;
          out_ += line(x, y, end_x, end_y);
        }
        out_ += text(tx, ty, "start", p.label,
                     fmt::format(" style=\"fill:{};stroke:var(--paper);stroke-width:3px;"
                                 "paint-order:stroke\"",
                                 variable(colour)));
        taken_.push_back(box);
        return;
      }
    }
  }

  template <class... Parts>
  void put(fmt::format_string<const Parts&...> format, const Parts&... parts) {
    fmt::format_to(std::back_inserter(out_), format, parts...);
  }

  const Plot& plot_;
  std::vector<int> bar_colours_, series_colours_;
  Scale x_, y_;
  std::vector<Rectangle> taken_;  // by points and labels
  std::string out_;
};

}  // namespace

std::string draw(const Plot& plot) { return Canvas(plot).result(); }

}  // namespace pvol::svg
