// Comparing pictures and measuring settings, as pvol-stats does.
#pragma once

#include <string>
#include <vector>

#include "python/pictures.h"

namespace pvol::python {

/// What pvol-stats image says of two pictures, as JSON. Throws what measure::compare throws.
[[nodiscard]] std::string compare_text(const Picture& a, const Picture& b);

/// Options by key, set together, with values as on a command line.
using Variant = std::vector<std::pair<std::string, std::string>>;

struct TradeRequest {
  SceneRequest scene;
  std::vector<Variant> variants{};  ///< none: every setting that pvol-stats trade measures
  double budget = 60;               ///< seconds of the clock
  std::uint32_t samples = 0;        ///< a pixel and round, at most; 0: as the budget allows
};

struct TradeRows {
  std::string text;                 ///< a JSON array, the default first
  std::vector<std::string> warnings;  ///< what is likely to be a mistake
};

/// The settings of what pvol-stats trade says. Throws Error, also where the budget is too short.
[[nodiscard]] TradeRows measure_trade(const TradeRequest& request, const Stop& stop);

}  // namespace pvol::python
