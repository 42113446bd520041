// The trade of speed for accuracy as measured, in words, tables and plots: the report of
// pvol-stats trade.
#pragma once

#include <string>

#include "cli/json.h"
#include "pvol/measure/study.h"
#include "report/document.h"
#include "stats/study_report.h"

namespace pvol::cli {

/// The command line that renders with a row's setting.
[[nodiscard]] std::string command_line(const StudyReport& report, const measure::Advice& advice);

/// The advice in a sentence, or why there is none.
[[nodiscard]] std::string advice_text(const StudyReport& report, const measure::Goal& goal);

/// "BIASED: mean -4.10 +- 0.31 %"; empty for an unbiased setting that was not caught.
[[nodiscard]] std::string verdict_text(const measure::Row& row);

/// With `pictures` what only pages show is drawn, too.
[[nodiscard]] report::Document trade_document(const StudyReport& report, bool pictures);

[[nodiscard]] Json trade_json(const StudyReport& report);

// --- the parts that a page draws (trade_figures.cpp) --------------------------------------------

/// Systematic error against cost, and error against time.
[[nodiscard]] report::Figures trade_plots(const StudyReport& report);
/// Ratios of time, variance and their product as bars.
[[nodiscard]] std::vector<report::Content> ratio_parts(const measure::Study& study);
/// Each biased setting beside the reference, and their difference.
[[nodiscard]] std::vector<report::Content> bias_parts(const measure::Study& study);

}  // namespace pvol::cli
