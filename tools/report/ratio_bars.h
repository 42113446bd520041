// Ratios as horizontal bars to either side of 1, for pages of html.h.
#pragma once

#include <span>
#include <string>

#include "pvol/measure/trade.h"

namespace pvol::svg {

struct RatioBar {
  std::string label;
  measure::Estimate ratio;  ///< above 0
  bool faint = false;       ///< biased settings, which stand back
};

/// An <svg> of one line for each bar, on a logarithmic axis: below 1 to the left, in the colour of
/// gains, above 1 to the right, each with its interval and its value.
[[nodiscard]] std::string draw_ratios(const std::string& title, std::span<const RatioBar> bars);

}  // namespace pvol::svg
