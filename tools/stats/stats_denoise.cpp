// The verb `trade` with --denoise: what filtering the picture gains and falsifies.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "cli/cli.h"
#include "cli/filter_picture.h"
#include "cli/instructions.h"
#include "pvol/error.h"
#include "report/html.h"
#include "report/terminal.h"
#include "stats/denoise_report.h"
#include "stats/stats_trade.h"
#include "stats/study_clock.h"

namespace pvol::cli {
namespace {

/// Part of the budget for the reference, which has to be much better than what it judges.
constexpr double kReferencePartOfFilter = 0.35;
constexpr int kFilteredPixels = 160 * 160;
constexpr int kTrials = 6, kFewestTrials = 3;
constexpr std::uint32_t kFirst = 4, kStep = 4;  // samples a pixel, and their growth

measure::Run render_once(const LoadedScene& loaded, bool for_filter, std::uint32_t samples,
                         std::uint64_t seed, double most_seconds) {
  const measure::RunRequest request{.samples = samples, .seed = seed, .most_seconds = most_seconds};
  ChangeScene change;
  if (for_filter) change = [](Scene& s) { s = with_needs_of_filter(s); };
  return render_changed(loaded, change, {}, request, 1);
}

/// The picture noisy and filtered, and timed without what the filter wants; nothing where time ran
/// out.
std::optional<measure::FilterTrial> try_once(const LoadedScene& loaded, std::uint32_t samples,
                                             std::uint64_t seed, double most_seconds) {
  const measure::Run plain = render_once(loaded, false, samples, seed, most_seconds);
  measure::Run run = render_once(loaded, true, samples, seed, most_seconds);
  if (!plain.complete || !run.complete) return std::nullopt;
  const double before = cpu_seconds();
  measure::FilterTrial t{.film = std::move(run.film), .filtered = {}};
  t.filtered = denoise(t.film, {.threads = 1});
  t.filter_seconds = cpu_seconds() - before;
  t.plain_seconds = plain.seconds, t.render_seconds = run.seconds;
  t.film.layers.clear();
  return t;
}

/// As many trials as there is time for: all, or none where that would be too few.
std::vector<measure::FilterTrial> try_often(StudyClock& clock, const LoadedScene& loaded,
                                            std::uint32_t samples) {
  std::vector<measure::FilterTrial> trials;
  double longest = 0;
  while (int(trials.size()) < kTrials && !interrupted() && clock.left() > longest) {
    clock.announce(
        fmt::format("{} samples per pixel, picture {} of {}", samples, trials.size() + 1, kTrials));
    const double begin = clock.left();
    auto t = try_once(loaded, samples, samples + trials.size(), clock.left());
    longest = std::max(longest, begin - clock.left());
    if (!t) break;
    trials.push_back(std::move(*t));
  }
  if (int(trials.size()) < kFewestTrials) trials.clear();
  return trials;
}

DenoiseReport measure_denoiser(const TradeOptions& o) {
  DenoiseReport report;
  StudyReport& base = report.base;
  base.loaded = load_scene(o.scene, kFilteredPixels, o.quiet);
  base.name = o.scene.input.string();
  base.given = words_of(o.scene, base.loaded);
  base.budget = o.budget;
  base.study.goals = goals_of(o);
  base.study.picture_pixels = double(base.loaded.picture_width) * base.loaded.picture_height;
  StudyClock clock(base, o.quiet);
  clock.measure_reference(base.loaded, kReferencePartOfFilter, o.threads);
  double last = 0;  // seconds of the clock for the samples before
  for (std::uint32_t samples = kFirst; samples <= base.study.reference_samples; samples *= kStep) {
    // Of the next number kFewestTrials must fit.
    if (interrupted() || last * kStep * kFewestTrials / kTrials > clock.left()) break;
    const double begin = clock.left();
    const std::vector<measure::FilterTrial> trials = try_often(clock, base.loaded, samples);
    if (trials.empty()) break;
    last = begin - clock.left();
    report.figures.push_back(measure::judge_filter(base.study.reference, trials));
  }
  if (report.figures.empty()) {
    throw Error(interrupted() ? "interrupted before anything was measured"
                              : "the budget is too short: raise --budget or lower --size");
  }
  clock.stop();
  return report;
}

}  // namespace

int run_denoise_trade(const TradeOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  const DenoiseReport report = measure_denoiser(o);
  const report::Document document = denoise_document(report);
  if (o.html) html::write_page(*o.html, document);
  if (o.json) {
    std::cout << to_text(denoise_json(report));
  } else if (!o.quiet) {
    std::cout << report::to_terminal(document);
  }
  StudyClock::require_whole();
  return kSuccess;
}

}  // namespace pvol::cli
