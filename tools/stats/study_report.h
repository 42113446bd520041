// What the reports of `depth` and `trade` share: a study of the user's scene, measured within a
// budget.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/interrupt.h"
#include "cli/json.h"
#include "pvol/measure/study.h"
#include "report/document.h"
#include "stats/stats_scene.h"

namespace pvol::cli {

struct StudyReport {
  std::string name;  ///< of the input
  LoadedScene loaded;
  std::vector<std::string> given;  ///< words of the command line that describe the scene
  double budget = 0, used = 0;     ///< seconds of the clock
  measure::Study study;
  std::unique_ptr<SavesOnInterrupt> saves;  ///< there as soon as there is something to report
};

/// What the user said of the scene, as pvol-render takes it.
[[nodiscard]] std::vector<std::string> words_of(const SceneOptions& o, const LoadedScene& loaded);

/// The command line that renders the picture with this option, or none, and so many samples.
[[nodiscard]] std::string render_command(const StudyReport& report, const std::string& option,
                                         double samples);

/// "default" or the option.
[[nodiscard]] std::string label(const measure::Variant& variant);

/// Rows that were measured, in order.
[[nodiscard]] std::vector<const measure::Row*> good_rows(const measure::Study& study);

/// "--depth 0: left out: one sample of each pixel takes more than 171 ms", for each that was not
/// measured.
[[nodiscard]] std::vector<report::Content> left_out_lines(const measure::Study& study);

/// What the page shows of look-ups by pixel: the maps of these rows, each named after its setting
/// with a word before it, after other figures.
[[nodiscard]] std::vector<report::Content> lookup_part(const std::vector<const measure::Row*>& rows,
                                                       std::string_view before,
                                                       std::vector<report::Figure> figures);

[[nodiscard]] Json to_json(const measure::Estimate& e);
/// File, medium and size: with these both reports begin.
[[nodiscard]] Json scene_json(const StudyReport& report);

}  // namespace pvol::cli
