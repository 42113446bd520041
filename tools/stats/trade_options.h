// The command lines of pvol-stats depth and trade.
#pragma once

#include <functional>

#include "stats/stats_trade.h"

namespace CLI {
class App;
}

namespace pvol::cli {

/// Adds a verb; parsing it makes `run` the work to do. The options must outlive it.
void add_depth(CLI::App& app, DepthOptions& o, std::function<int()>& run);
void add_trade(CLI::App& app, TradeOptions& o, std::function<int()>& run);

}  // namespace pvol::cli
