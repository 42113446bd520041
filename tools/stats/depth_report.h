// What the octree's depth costs and gains, as measured: the table and figures of pvol-stats depth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/json.h"
#include "pvol/measure/compare.h"
#include "pvol/measure/trade.h"
#include "stats/stats_scene.h"

namespace pvol::cli {

/// CPU seconds of building, by round.
struct BuildTimes {
  std::vector<double> bounds;  ///< extremes of all voxels down to leaves of 8^3
  std::vector<double> tree;    ///< bricks and octree
};

/// One depth that the user asked for, which may stop where another one does.
struct DepthRow {
  int asked = 0;
  int depth = 0;  ///< at which the walk stops: not below the cloud's leaves
  measure::Measured measured;
  BuildTimes build;
  // Where it was measured, relative to the first row:
  measure::Estimate build_ratio;                ///< building, over the first row's
  measure::Estimate tree_ratio;                 ///< its second part alone
  measure::Estimate time;                       ///< of a sample
  measure::Estimate cost;                       ///< time x variance
  double lookup_cost = 0;                       ///< look-ups x variance
  double lookups = 0, tests = 0, segments = 0;  ///< a sample
  double rmse = 0;  ///< of one sample a pixel, against the reference, over its mean
  measure::FilmComparison bias;
  [[nodiscard]] bool good() const { return measured.left_out.empty(); }
};

struct DepthReport {
  std::string name;  ///< of the input
  LoadedScene loaded;
  double budget = 0, used = 0;
  Film reference;
  std::vector<DepthRow> rows;  ///< the first is what the others are compared with
};

/// Fills what follows from `measured` and `build`.
void relate(DepthReport& report);

void print_depth(const DepthReport& report);
[[nodiscard]] Json depth_json(const DepthReport& report);
void write_depth_page(const std::filesystem::path& file, const DepthReport& report);

}  // namespace pvol::cli
