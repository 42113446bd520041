// What the octree's depth costs and gains, as measured: the report of pvol-stats depth, a study
// whose settings are depths.
#pragma once

#include <vector>

#include "cli/json.h"
#include "pvol/measure/study.h"
#include "report/document.h"
#include "stats/study_report.h"

namespace pvol::cli {

/// One depth that the user asked for, which may stop where another one does. Its row of the study
/// has the same number.
struct DepthRow {
  int asked = 0;
  int depth = 0;  ///< the same, or that of the walks without a limit where it is less
  measure::BuildTimes build;
};

struct DepthReport {
  StudyReport base;
  std::vector<DepthRow> depths;
};

/// "8 = 5" where walks go no deeper than 5 without a limit.
[[nodiscard]] std::string depth_text(const DepthRow& row);

/// With `pictures` what only pages show is drawn, too.
[[nodiscard]] report::Document depth_document(const DepthReport& report, bool pictures);

[[nodiscard]] Json depth_json(const DepthReport& report);

}  // namespace pvol::cli
