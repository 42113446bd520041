#include "stats/denoise_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

using measure::FilterAdvice;
using measure::FilterFigures;
using report::Text;

/// "2.31 (2.20-2.41)" in per cent, of a root whose square has this interval.
std::string percent_of_root(double value, double square_half_width) {
  const double square = value * value;
  const auto end = [&](double s) { return 100 * std::sqrt(std::max(0.0, s)); };
  return fmt::format("{:.3g} ({:.3g}-{:.3g})", 100 * value, end(square - square_half_width),
                     end(square + square_half_width));
}

report::Table table_of(const DenoiseReport& report) {
  report::Table t{.caption = "Errors in % of the mean luminance, by samples per pixel",
                  .header = {"spp", "noise", "filtered", "estimated", "bias of mean", "systematic",
                             "layers", "filter", "gain"}};
  for (const FilterFigures& f : report.figures) {
    t.rows.push_back({fmt::format("{:.0f}", f.samples), fmt::format("{:.3g}", 100 * f.noisy),
                      percent_of_root(f.filtered, f.filtered_square_half_width),
                      fmt::format("{:.3g}", 100 * f.estimated),
                      fmt::format("{:+.2g} ± {:.2g}", 100 * f.bias.value, 100 * f.bias.half_width),
                      percent_of_root(f.systematic, f.systematic_square_half_width),
                      fmt::format("{:.2f}", f.render_seconds / f.plain_seconds),
                      readable_seconds(f.filter_seconds), fmt::format("{:.2f}", f.gain())});
  }
  return t;
}

Text notes(const DenoiseReport& report) {
  return {fmt::format(
      "{} pictures in each row, against {} samples per pixel; intervals of 95 %. noise: error "
      "without the filter. estimated: the filter's own estimate of its error. bias of mean: light "
      "that the filter adds to the whole picture; systematic: its error in pixels, which no number "
      "of pictures averages out. layers: time of rendering with all layers that the filter needs, "
      "over that without. filter: its own CPU time. gain: CPU time of an unfiltered picture of the "
      "same error, over that of the filtered one.",
      report.figures.empty() ? 0 : report.figures.front().trials,
      report.base.study.reference_samples)};
}

/// Times and samples of the whole picture that a goal is about.
struct Ways {
  FilterAdvice plain;
  std::optional<FilterAdvice> filtered;
};

Ways ways_to(const DenoiseReport& report, double error) {
  const measure::Study& study = report.base.study;
  const double scale = study.picture_pixels / double(study.reference.pixels.size());
  Ways w{measure::advise_plain(report.figures, error),
         measure::advise_filtered(report.figures, error)};
  w.plain.samples = std::ceil(w.plain.samples), w.plain.seconds *= scale;
  if (w.filtered) w.filtered->samples = std::ceil(w.filtered->samples);
  if (w.filtered) w.filtered->seconds *= scale;
  return w;
}

bool filter_wins(const Ways& w) { return w.filtered && w.filtered->seconds < w.plain.seconds; }

std::string command_for(const DenoiseReport& report, const Ways& w) {
  return filter_wins(w) ? render_command(report.base, "--denoise", w.filtered->samples)
                        : render_command(report.base, "", w.plain.samples);
}

report::Verdict verdict_of(const DenoiseReport& report, double error) {
  const Ways w = ways_to(report, error);
  const LoadedScene& loaded = report.base.loaded;
  const std::string filtered =
      w.filtered ? fmt::format("{} filtered", readable_seconds(w.filtered->seconds))
                 : std::string("not reached with the filter");
  return {fmt::format("for a relative error of {:.4g} %, {}x{} pixels: about {} of CPU time, {}",
                      100 * error, loaded.picture_width, loaded.picture_height,
                      readable_seconds(w.plain.seconds), filtered),
          report::Mood::plain, command_for(report, w)};
}

Json square_json(double value, double half_width) {
  return {{"value", value},
          {"low", std::sqrt(std::max(0.0, value * value - half_width))},
          {"high", std::sqrt(value * value + half_width)}};
}

}  // namespace

report::Document denoise_document(const DenoiseReport& report) {
  const StudyReport& base = report.base;
  report::Document d{.title = "What the filter gains: " + base.name,
                     .subject = base.name,
                     .lead = describe(base.loaded)};
  add(d, report::Heading{"The filter"});
  add(d, table_of(report));
  add(d, notes(report));
  add(d, report::Heading{"Time to an error"});
  for (const measure::Goal& g : base.study.goals) {
    if (g.error) add(d, verdict_of(report, *g.error));
  }
  return d;
}

Json denoise_json(const DenoiseReport& report) {
  const StudyReport& base = report.base;
  Json j = scene_json(base);
  j["picture_size"] = {base.loaded.picture_width, base.loaded.picture_height};
  j["budget_seconds"] = base.budget;
  j["used_seconds"] = base.used;
  j["reference"] = {{"samples", base.study.reference_samples}, {"mean", base.study.reference_mean}};
  j["denoise"] = Json::array();
  for (const FilterFigures& f : report.figures) {
    j["denoise"].push_back(
        {{"samples", f.samples},
         {"pictures", f.trials},
         {"noise", f.noisy},
         {"filtered", square_json(f.filtered, f.filtered_square_half_width)},
         {"estimated", f.estimated},
         {"bias_of_mean", {{"value", f.bias.value}, {"half_width", f.bias.half_width}}},
         {"systematic", square_json(f.systematic, f.systematic_square_half_width)},
         {"cpu_seconds",
          {{"plain", f.plain_seconds},
           {"with_layers", f.render_seconds},
           {"filter", f.filter_seconds}}},
         {"gain", f.gain()}});
  }
  j["goals"] = Json::array();
  for (const measure::Goal& g : base.study.goals) {
    if (!g.error) continue;
    const Ways w = ways_to(report, *g.error);
    Json goal{{"relative_error", *g.error},
              {"plain", {{"samples", w.plain.samples}, {"cpu_seconds", w.plain.seconds}}},
              {"command", command_for(report, w)}};
    if (w.filtered) {
      goal["filtered"] = {{"samples", w.filtered->samples}, {"cpu_seconds", w.filtered->seconds}};
    }
    j["goals"].push_back(goal);
  }
  return j;
}

}  // namespace pvol::cli
