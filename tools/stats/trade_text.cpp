// The report of pvol-stats trade for a terminal, and as JSON for scripts.
#include <cmath>
#include <iostream>

#include "cli/cli.h"
#include "cli/columns.h"
#include "stats/trade_report.h"

namespace pvol::cli {
namespace {

/// Three significant digits, never in powers of ten for what ratios are.
std::string ratio(double v) {
  return formatted(v < 9.995 ? "%.2f" : v < 99.95 ? "%.1f" : "%.0f", v);
}

std::string with_interval(const measure::Estimate& e) {
  return ratio(e.value) + " (" + ratio(e.low) + "-" + ratio(e.high) + ")";
}

double per_sample(const measure::Measured& m, std::uint64_t count) {
  return m.counted > 0 ? double(count) / double(m.counted) : 0;
}

}  // namespace

std::vector<std::string> trade_header() {
  return {"setting",  "time",  "variance",        "time x variance",
          "look-ups", "bytes", "bias of the mean"};
}

std::string bias_text(const TradeRow& row) {
  const measure::ChannelComparison& c = row.bias.luminance;
  const double percent = 100 / c.mean_b;
  if (!std::isfinite(percent)) return "-";
  return formatted("%+.2f", c.bias * percent) + " +- " +
         formatted("%.2f", c.bias_half_width * std::abs(percent)) + " %";
}

std::vector<std::string> trade_cells(const TradeRow& row) {
  const measure::Measured& m = row.measured;
  const Counts& k = m.counts;
  return {label(row.variant),
          with_interval(row.time),
          ratio(row.variance.value),
          with_interval(row.cost),
          formatted("%.4g", per_sample(m, k.lookups_path + k.lookups_shadow)),
          readable_bytes(m.set_up.bytes()),
          bias_text(row)};
}

std::string verdict_text(const TradeRow& row) {
  if (!row.detected()) return row.variant.biased ? "biased by design, not detected" : "";
  const measure::ChannelComparison& c = row.bias.luminance;
  std::string text = "BIASED: mean " + bias_text(row);
  if (std::abs(c.bias) <= c.bias_half_width) {
    text += ", by place: " + formatted("%.2g", 100 * row.offset()) + " % or less";
  }
  return row.variant.biased ? text : text + ", though it should not be: please report this";
}

std::string coverage_text(const TradeReport& report) {
  double least = 1;
  int fewest = 1 << 30;
  for (const TradeRow& row : report.rows) {
    if (!row.good()) continue;
    least = std::min(least, row.time.coverage);
    fewest = std::min(fewest, row.measured.rounds());
  }
  return "Ratios to the default: medians of " + std::to_string(fewest) +
         " rounds or more, in which the settings took turns; intervals hold the median with " +
         formatted("%.0f", 100 * least) + " % or more.";
}

std::string bias_note(const TradeReport& report) {
  return "Bias: against " + std::to_string(report.reference_samples) +
         " samples a pixel of the default, with 95 % intervals. No unbiased setting is called "
         "biased but with " +
         formatted("%.0f", 100 * kTradeFalseAlarms) + " % probability for the whole table.";
}

void print_trade(const TradeReport& report) {
  constexpr std::size_t kNames = 33;
  static constexpr std::size_t kWidths[] = {0, 18, 9, 18, 9, 8, 18};
  const auto print = [&](const char* mark, const std::vector<std::string>& cells) {
    std::cout << mark;
    const bool apart = cells[0].size() >= kNames;  // of combinations
    if (apart) std::cout << cells[0] << "\n  ";
    std::cout << left_in(apart ? "" : cells[0], kNames);
    for (std::size_t i = 1; i < cells.size(); ++i) std::cout << right_in(cells[i], kWidths[i]);
    std::cout << '\n';
  };
  std::cout << wrapped(report.name + ": " + describe(report.loaded)) << '\n';
  print("  ", trade_header());
  for (const TradeRow& r : report.rows) {
    if (r.good()) print(r.on_front ? "* " : "  ", trade_cells(r));
  }
  std::cout
      << '\n'
      << wrapped(
             "* on the Pareto front of time x variance, systematic error, and bytes in memory "
             "and file; the default stands for settings that noise does not tell from it")
      << wrapped(coverage_text(report)) << wrapped(bias_note(report))
      << wrapped(std::string("Look-ups: per sample. ") +
                 (report.rows[0].instructions ? "Instructions are in --json."
                                              : "Instructions: not counted on this machine."))
      << '\n';
  for (const TradeRow& r : report.rows) {
    const std::string verdict = r.good() ? verdict_text(r) : "";
    if (!verdict.empty()) std::cout << wrapped(label(r.variant) + ": " + verdict);
  }
  for (const TradeRow& r : report.rows) {
    if (!r.good()) {
      std::cout << wrapped(label(r.variant) + ": left out: " + r.measured.left_out, 110, "  ");
    }
  }
  std::cout << '\n';
  for (const Goal& g : report.goals) {
    std::cout << wrapped(advice_text(report, g));
    if (g.advice) std::cout << "  " << command_line(report, *g.advice) << '\n';
  }
}

// --- JSON ---------------------------------------------------------------------------------------

namespace {

Json to_json(const measure::Estimate& e) {
  return {{"value", e.value}, {"low", e.low}, {"high", e.high}, {"coverage", e.coverage}};
}

Json to_json(const Counts& c, std::uint64_t samples) {
  return {{"samples", samples},
          {"lookups_path", c.lookups_path},
          {"lookups_shadow", c.lookups_shadow},
          {"bounds_tests_path", c.bounds_tests_path},
          {"bounds_tests_shadow", c.bounds_tests_shadow},
          {"segments_path", c.segments_path},
          {"segments_shadow", c.segments_shadow},
          {"collisions", c.collisions},
          {"null_collisions", c.null_collisions},
          {"shadow_rays", c.shadow_rays},
          {"shell_tests", c.shell_tests},
          {"shell_rejections", c.shell_rejections}};
}

Json bias_json(const TradeRow& row) {
  const measure::ChannelComparison& c = row.bias.luminance;
  Json j{{"mean", c.mean_a},
         {"bias", c.bias},
         {"bias_half_width", c.bias_half_width},
         {"relative_bias", c.relative_bias},
         {"rmse", c.rmse},
         {"systematic_mse", c.systematic_mse},
         {"systematic_half_width", c.systematic_half_width},
         {"relative_systematic_error_at_most", row.offset()}};
  if (row.bias.verdict) j["p_value"] = row.bias.verdict->p_value;
  j["detected"] = row.detected();
  return j;
}

Json to_json(const TradeRow& row) {
  const measure::Measured& m = row.measured;
  Json j{{"setting", label(row.variant)},
         {"factor", row.variant.factor},
         {"biased_by_design", row.variant.biased}};
  if (!row.good()) {
    j["left_out"] = m.left_out;
    return j;
  }
  j["samples_per_round"] = m.samples;
  j["rounds"] = m.rounds();
  j["cpu_seconds_per_sample"] = row.setting.seconds;
  j["variance_per_sample"] = measure::sample_variance(m.film);
  j["time"] = to_json(row.time);
  j["variance"] = to_json(row.variance);
  j["time_x_variance"] = to_json(row.cost);
  j["instructions"] = row.instructions ? to_json(*row.instructions) : Json();
  j["counts"] = to_json(m.counts, m.counted);
  j["set_up_cpu_seconds"] = row.setting.set_up;
  j["depth"] = m.set_up.depth;
  j["bytes"] = {{"field", m.set_up.field_bytes},
                {"octree", m.set_up.octree_bytes},
                {"micro_bounds", m.set_up.micro_bytes},
                {"file", row.file_bytes}};
  j["bias"] = bias_json(row);
  j["on_front"] = row.on_front;
  return j;
}

Json to_json(const TradeReport& report, const Goal& g) {
  Json j;
  if (g.error) j["relative_error"] = *g.error;
  if (g.seconds) j["cpu_seconds"] = *g.seconds;
  if (!g.advice) return j;
  j["advice"] = {{"setting", label(report.rows[g.advice->setting].variant)},
                 {"samples", g.advice->samples},
                 {"cpu_seconds", g.advice->seconds},
                 {"relative_error", g.advice->error},
                 {"command", command_line(report, *g.advice)}};
  return j;
}

}  // namespace

Json trade_json(const TradeReport& report) {
  const RenderOptions& o = report.loaded.file.scene.options;
  Json j{{"file", report.name},
         {"extinction", report.loaded.file.scene.medium.extinction},
         {"mean_optical_thickness", report.loaded.facts.front().mean_optical_thickness},
         {"size", {o.width, o.height}},
         {"picture_size", {report.loaded.picture_width, report.loaded.picture_height}},
         {"budget_seconds", report.budget},
         {"used_seconds", report.used},
         {"reference", {{"samples", report.reference_samples}, {"mean", report.reference_mean}}},
         {"false_alarm_rate", kTradeFalseAlarms},
         {"level", report.level}};
  j["settings"] = Json::array();
  for (const TradeRow& row : report.rows) j["settings"].push_back(to_json(row));
  j["goals"] = Json::array();
  for (const Goal& g : report.goals) j["goals"].push_back(to_json(report, g));
  return j;
}

}  // namespace pvol::cli
