// The report of pvol-stats trade for scripts.
#include "stats/trade_report.h"

namespace pvol::cli {
namespace {

Json counts_json(const Counts& c, std::uint64_t samples) {
  return {{"samples", samples},
          {"lookups_path", c.path.lookups},
          {"lookups_shadow", c.shadow.lookups},
          {"bounds_tests_path", c.path.bounds_tests},
          {"bounds_tests_shadow", c.shadow.bounds_tests},
          {"segments_path", c.path.segments},
          {"segments_shadow", c.shadow.segments},
          {"collisions", c.collisions},
          {"null_collisions", c.path.null_collisions},
          {"shadow_rays", c.shadow_rays},
          {"shell_tests", c.shell_tests},
          {"shell_rejections", c.shell_rejections}};
}

Json bias_json(const measure::Row& row) {
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

Json row_json(const measure::Row& row) {
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
  j["variance_per_sample"] = row.sample_variance;
  j["time"] = to_json(row.time);
  j["variance"] = to_json(row.variance);
  j["time_x_variance"] = to_json(row.cost);
  j["instructions"] = row.instructions ? to_json(*row.instructions) : Json();
  j["counts"] = counts_json(m.counts, m.counted);
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

Json goal_json(const StudyReport& report, const measure::Goal& g) {
  Json j;
  if (g.error) j["relative_error"] = *g.error;
  if (g.seconds) j["cpu_seconds"] = *g.seconds;
  if (!g.advice) return j;
  j["advice"] = {{"setting", label(report.study.rows[g.advice->setting].variant)},
                 {"samples", g.advice->samples},
                 {"cpu_seconds", g.advice->seconds},
                 {"relative_error", g.advice->error},
                 {"command", command_line(report, *g.advice)}};
  return j;
}

}  // namespace

Json trade_json(const StudyReport& report) {
  const measure::Study& study = report.study;
  Json j = scene_json(report);
  j["picture_size"] = {report.loaded.picture_width, report.loaded.picture_height};
  j["budget_seconds"] = report.budget;
  j["used_seconds"] = report.used;
  j["reference"] = {{"samples", study.reference_samples}, {"mean", study.reference_mean}};
  j["false_alarm_rate"] = measure::kFalseAlarms;
  j["level"] = study.level;
  j["settings"] = Json::array();
  for (const measure::Row& row : study.rows) j["settings"].push_back(row_json(row));
  j["goals"] = Json::array();
  for (const measure::Goal& g : study.goals) j["goals"].push_back(goal_json(report, g));
  return j;
}

}  // namespace pvol::cli
