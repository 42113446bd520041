// The command lines of pvol-stats depth and trade.
#pragma once

#include <functional>

#include "cli/command_line.h"
#include "stats/stats_trade.h"

namespace pvol::cli {

/// Adds a verb; parsing it makes `run` the work to do. The options must outlive it.
void add_depth(const CommandLine& app, DepthOptions& o, std::function<int()>& run);
void add_trade(const CommandLine& app, TradeOptions& o, std::function<int()>& run);

}  // namespace pvol::cli
