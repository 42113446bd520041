// The verb `trade`: what each option of the renderer costs and gains on the user's own scene.
#include <fmt/format.h>

#include <iostream>
#include <iterator>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/measure/study.h"
#include "report/html.h"
#include "report/terminal.h"
#include "stats/stats_trade.h"
#include "stats/study_clock.h"
#include "stats/trade_report.h"
#include "stats/trade_variants.h"

namespace pvol::cli {
namespace {

/// Part of the budget for settings of one factor; combinations get what they and the reference
/// leave.
constexpr double kSinglesPart = 0.65;

/// A file in a folder of its own, removed at the end.
class ScratchFile {
 public:
  ScratchFile() {
    std::string name = (std::filesystem::temp_directory_path() / "pvol-stats-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw Error(name + ": cannot be made");
    folder_ = name;
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  [[nodiscard]] std::filesystem::path path() const { return folder_ / "cloud.pvol"; }

 private:
  std::filesystem::path folder_;
};

/// Bytes of the .pvol files that hold these clouds with their density.
std::uint64_t file_bytes(const std::vector<formats::Cloud>& clouds, const ChangeCloud& change) {
  const ScratchFile scratch;
  std::uint64_t bytes = 0;
  for (formats::Cloud cloud : clouds) {
    if (change) change(cloud);
    formats::PvolFile file;
    file.metadata = cloud.metadata;
    file.pyramid = cloud.pyramid;
    file.shell = cloud.shell;
    if (cloud.metadata.quantisation.precision != Precision::fp32) {
      file.codes = quantise(cloud.grid(), cloud.metadata.quantisation);
    } else if (!cloud.recipe()) {
      file.density = cloud.grid();
    }
    file.metadata.grid_name = cloud.grid().name;
    file.metadata.index_to_world = cloud.grid().index_to_world;
    bytes += formats::write_pvol(scratch.path(), file).total;
  }
  return bytes;
}

/// The default and these candidates, in turn.
std::vector<measure::Row> measure(StudyClock& clock, const LoadedScene& loaded,
                                  std::vector<Candidate> candidates, double seconds,
                                  std::uint64_t seed) {
  candidates.insert(candidates.begin(), default_candidate());
  std::vector<std::string> names;
  std::vector<measure::Variant> variants;
  for (const Candidate& c : candidates) {
    names.push_back(label(c.variant));
    variants.push_back(c.variant);
  }
  constexpr std::uint32_t kMostSamples = 1u << 16;
  // A bias by design need not show in a pilot, and files differ in bytes that no picture shows.
  const auto always = [&](std::size_t i) {
    return candidates[i].variant.biased || candidates[i].cloud;
  };
  std::vector<measure::Measured> measured =
      clock.sweep(names, seconds, seed, kMostSamples, always, [&](const measure::RunRequest& r) {
        // One thread: times and instructions are then those of the work alone.
        const Candidate& c = candidates[r.setting];
        return render_changed(loaded, c.scene, c.cloud, r, 1);
      });
  return measure::make_rows(variants, std::move(measured));
}

/// Sizes of files that hold the clouds as each setting wants them.
void measure_files(StudyReport& report, const std::vector<Candidate>& candidates) {
  const std::uint64_t plain = file_bytes(report.loaded.clouds, {});
  for (std::size_t i = 0; i < report.study.rows.size(); ++i) {
    measure::Row& row = report.study.rows[i];
    if (!row.good()) continue;
    const ChangeCloud change = i == 0 ? ChangeCloud{} : candidates[i - 1].cloud;
    row.file_bytes = change ? file_bytes(report.loaded.clouds, change) : plain;
  }
}

/// Combinations in what is left of the budget; where that is too short even for the default beside
/// them, all of them are left out, and the settings measured before stand.
std::vector<measure::Row> measure_combinations(StudyClock& clock, const LoadedScene& loaded,
                                               const std::vector<Candidate>& joined) {
  constexpr std::uint64_t kSeeds = std::uint64_t(1) << 20;
  try {
    std::vector<measure::Row> rows = measure(clock, loaded, joined, clock.left(), kSeeds);
    rows.erase(rows.begin());
    return rows;
  } catch (const Error& e) {
    std::vector<measure::Row> rows(joined.size());
    for (std::size_t i = 0; i < joined.size(); ++i) {
      rows[i].variant = joined[i].variant;
      rows[i].measured.left_out = e.what();
    }
    return rows;
  }
}

StudyReport measure_trade(const TradeOptions& o) {
  StudyReport report;
  measure::Study& study = report.study;
  report.loaded = load_scene(o.scene, kPixelsOfStudy, o.quiet);
  report.name = o.scene.input.string();
  report.given = words_of(o.scene, report.loaded);
  report.budget = o.budget;
  study.goals = goals_of(o);
  study.picture_pixels = double(report.loaded.picture_width) * report.loaded.picture_height;
  StudyClock clock(report, o.quiet);
  clock.measure_reference(report.loaded, kReferencePart, o.threads);

  std::vector<Candidate> candidates = single_candidates(report.loaded);
  const double part = kSinglesPart / (1 - kReferencePart);
  study.rows = measure(clock, report.loaded, candidates, part * clock.left(), 1);
  measure::test_biases(study);

  std::vector<measure::VariantResult> results;
  for (std::size_t i = 1; i < study.rows.size(); ++i) {
    results.push_back(measure::result_of(study.rows[i]));
  }
  const std::vector<Candidate> joined = combinations(candidates, results);
  if (!joined.empty() && !interrupted()) {
    std::vector<measure::Row> rows = measure_combinations(clock, report.loaded, joined);
    study.rows.insert(study.rows.end(), std::make_move_iterator(rows.begin()),
                      std::make_move_iterator(rows.end()));
    candidates.insert(candidates.end(), joined.begin(), joined.end());
  }
  measure_files(report, candidates);
  measure::judge(study);
  clock.stop();
  return report;
}

}  // namespace

std::vector<measure::Goal> goals_of(const TradeOptions& o) {
  if (o.most_error) return {{.error = *o.most_error}};
  if (o.most_time) return {{.seconds = *o.most_time}};
  return {{.error = 0.1}, {.error = 0.03}, {.error = 0.01}};
}

int run_trade(const TradeOptions& o) {
  if (o.denoise) return run_denoise_trade(o);
  if (o.html) check_output(*o.html, {".html", ".htm"});
  const StudyReport report = measure_trade(o);
  const report::Document document = trade_document(report, o.html.has_value());
  if (o.html) html::write_page(*o.html, document);
  if (o.json) {
    std::cout << to_text(trade_json(report));
  } else if (!o.quiet) {
    std::cout << report::to_terminal(document);
  }
  StudyClock::require_whole();
  return kSuccess;
}

}  // namespace pvol::cli
