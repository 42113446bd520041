// What filtering pictures gains and falsifies, in words and a table: the report of
// pvol-stats trade --denoise.
#pragma once

#include <vector>

#include "cli/json.h"
#include "pvol/measure/filtered.h"
#include "report/document.h"
#include "stats/study_report.h"

namespace pvol::cli {

struct DenoiseReport {
  StudyReport base;  ///< its study has the reference and the goals, and no rows
  std::vector<measure::FilterFigures> figures;  ///< by samples
};

[[nodiscard]] report::Document denoise_document(const DenoiseReport& report);
[[nodiscard]] Json denoise_json(const DenoiseReport& report);

}  // namespace pvol::cli
