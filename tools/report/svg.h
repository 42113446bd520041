// Plots as SVG, for pages of html.h, whose colours they use.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace pvol::svg {

struct Axis {
  std::string label;  ///< with its unit
  bool logarithmic = false;
  std::optional<double> lo{}, hi{};  ///< else from what is drawn, and 0 for the height of bars
};

struct Point {
  double x = 0, y = 0;
  double error = 0;     ///< half of the bar through the point
  std::string label{};  ///< beside the point, where there is room
};

enum class Style {
  line,    ///< a line through points
  curve,   ///< the line alone
  points,  ///< points alone
  steps,   ///< a stair through points in order of x, for Pareto fronts: right, then down
};

struct Series {
  std::string name;  ///< in the legend; none where empty
  std::vector<Point> points;
  Style style = Style::line;
  std::optional<int> colour{};  ///< of 8, else by order
  bool dashed = false;
};

/// A bar from x0 to x1, as high as y.
struct Bar {
  double x0 = 0, x1 = 0, y = 0;
};

struct Bars {
  std::string name;
  std::vector<Bar> bars;
  std::optional<int> colour{};
};

/// What is drawn on two axes. Values that are not finite, or not above 0 on a logarithmic axis,
/// are left out; error bars there end at the axis.
struct Plot {
  std::string title;
  Axis x, y;
  std::vector<Series> series{};
  std::vector<Bars> bars{};  ///< behind the series
};

/// An <svg> that scales with the page. Labels of points are set where they hide neither points nor
/// other labels, and left out where there is no such place; every point tells its label and values
/// when pointed at. The same plot gives the same text.
[[nodiscard]] std::string draw(const Plot& plot);

/// Positions of an axis's marks from lo to hi, about `count` of them, and their texts. Linear:
/// multiples of 1, 2 or 5 times a power of ten. Logarithmic: powers of ten, with 2 and 5 times them
/// where the range is short; lo > 0.
struct Mark {
  double at = 0;
  std::string text;
};
[[nodiscard]] std::vector<Mark> marks(double lo, double hi, bool logarithmic, int count);

}  // namespace pvol::svg
