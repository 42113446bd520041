// The verbs of pvol-stats that render: depth and trade.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pvol/measure/study.h"
#include "stats/stats_array.h"
#include "stats/stats_scene.h"

namespace pvol::cli {

struct DepthOptions {
  SceneOptions scene;
  StatsArray array{};
  std::vector<int> depths{0, 4, 8, 16};
  std::optional<std::string> tracker;
  std::uint32_t most_samples = 65536;  ///< a pixel and round
  double budget = 120;                 ///< seconds of the clock
  std::optional<std::filesystem::path> html;
  bool json = false, quiet = false;
};
[[nodiscard]] int run_depth(const DepthOptions& o);

struct TradeOptions {
  SceneOptions scene;
  StatsArray array{};
  std::optional<double> most_error;  ///< relative
  std::optional<double> most_time;   ///< CPU seconds of the picture
  bool denoise = false;              ///< measure the filter instead of the settings
  double budget = 300;               ///< seconds of the clock
  int threads = 0;                   ///< of the reference
  std::optional<std::filesystem::path> html;
  bool json = false, quiet = false;
};
[[nodiscard]] int run_trade(const TradeOptions& o);

/// The goals asked for, else three errors.
[[nodiscard]] std::vector<measure::Goal> goals_of(const TradeOptions& o);

/// run_trade for --denoise: one number of samples after the other, noisy and filtered.
[[nodiscard]] int run_denoise_trade(const TradeOptions& o);

}  // namespace pvol::cli
