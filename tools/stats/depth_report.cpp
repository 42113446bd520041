#include "stats/depth_report.h"

#include <fmt/format.h>

#include "cli/cli.h"
#include "pvol/measure/pixel_maps.h"
#include "report/film_pictures.h"
#include "report/svg.h"

namespace pvol::cli {
namespace {

using measure::Row;
using measure::Study;
using report::Shown;
using report::Text;

/// Table 1 of the paper, against no octree.
struct PaperRow {
  int depth;
  double build, tracking;  ///< building grows, tracking falls by this factor
};
constexpr PaperRow kPaper[] = {{4, 4.92, 4.34}, {8, 11.47, 20.42}, {16, 14.31, 19.02}};
constexpr const char* kPaperLine =
    "In the paper \"Rendering of inhomogeneous volumes using perturbation functions\", of its own "
    "clouds (table 1), against no octree, at depths 4 / 8 / 16: building takes 4.92 / 11.47 / "
    "14.31 times as long, tracking 4.34 / 20.42 / 19.02 times less.";

/// A depth with its figures, and what both are compared with.
struct Line {
  const DepthRow &depth, &first_depth;
  const Row &row, &first;
  [[nodiscard]] measure::BuildRatios building() const {
    return measure::compare_building(depth.build, first_depth.build);
  }
};

/// The depths that were measured.
std::vector<Line> good_lines(const DepthReport& r) {
  std::vector<Line> lines;
  const std::vector<Row>& rows = r.base.study.rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].good()) lines.push_back({r.depths[i], r.depths[0], rows[i], rows[0]});
  }
  return lines;
}

// --- words --------------------------------------------------------------------------------------

report::Table depth_table(const DepthReport& report) {
  report::Table t{
      .caption = "One row per depth; factors are relative to the first",
      .header = {"depth", "bounds", "tree", "built x", "us/sample", "tracking less by", "look-ups",
                 "tests", "segm.", "RMSE 1 spp", "look-ups x var less by", "time x var less by"},
      .split = 6};
  for (const Line& l : good_lines(report)) {
    const Row& r = l.row;
    const measure::Estimate tracking = measure::inverse(r.time);
    t.rows.push_back(
        {depth_text(l.depth), readable_seconds(measure::median(l.depth.build.bounds)),
         readable_seconds(measure::median(l.depth.build.tree)),
         fmt::format("{:.2f}", l.building().all.value),
         fmt::format("{:.3g}", 1e6 * measure::median(r.measured.seconds)),
         fmt::format("{:.2f} ({:.2f}-{:.2f})", tracking.value, tracking.low, tracking.high),
         fmt::format("{:.4g}", r.work.lookups), fmt::format("{:.4g}", r.work.bounds_tests),
         fmt::format("{:.4g}", r.work.segments), fmt::format("{:.3g}", r.rmse_of_one_sample),
         fmt::format("{:.2f}", l.first.lookup_cost() / r.lookup_cost()),
         fmt::format("{:.2f}", measure::inverse(r.cost).value)});
  }
  return t;
}

std::string settings_text(const StudyReport& report) {
  const RenderOptions& o = report.loaded.file.scene.options;
  return fmt::format("tracker {}, shadow rays {}, micro-bounds {} at every depth", name(o.tracker),
                     name(o.transmittance), name(o.micro_bounds));
}

Text notes(const Study& study) {
  return {
      fmt::format("Factors relative to the first row: medians over rounds in which the depths took "
                  "turns; intervals contain the median with a probability of at least {:.0f} %. "
                  "bounds: from all voxels, the same for every depth; tree: bricks and octree. "
                  "RMSE: over the mean, against {} samples per pixel.",
                  100 * measure::coverage(study).probability, study.reference_samples)};
}

Text bias_note(const DepthReport& report) {
  std::string biased;
  for (const Line& l : good_lines(report)) {
    if (!l.row.detected()) continue;
    biased += fmt::format("{}{}", biased.empty() ? "" : ", ", l.depth.asked);
  }
  return {biased.empty() ? "No depth differs from the reference beyond noise."
                         : "BIASED, which is an error of pvol; please report it: depth " + biased};
}

// --- plots --------------------------------------------------------------------------------------

/// A figure of the paper with ours beside it.
svg::Plot beside_paper(const DepthReport& report, const char* title, const char* axis,
                       double (*ours)(const Line&), double PaperRow::*theirs) {
  constexpr double kHalf = 0.7;  // of a pair of bars, in depths
  svg::Bars mine{.name = "this cloud", .bars = {}, .colour = 0},
      paper{.name = "the paper's", .bars = {}, .colour = 1};
  for (const Line& l : good_lines(report)) {
    mine.bars.push_back({l.depth.asked - kHalf, double(l.depth.asked), ours(l)});
  }
  for (const PaperRow& p : kPaper) {
    paper.bars.push_back({double(p.depth), p.depth + kHalf, p.*theirs});
  }
  return {
      .title = title, .x = {.label = "octree depth"}, .y = {.label = axis}, .bars = {mine, paper}};
}

report::Figures paper_figures(const DepthReport& report) {
  return {
      {{svg::draw(beside_paper(
            report, "Increase in the calculation time of the octree",
            "times that of the first depth", [](const Line& l) { return l.building().all.value; },
            &PaperRow::build)),
        "As the paper's figure 3. Bounds are made from all voxels for every depth, so building "
        "hardly depends on it here."},
       {svg::draw(beside_paper(
            report, "Decrease in the calculation time of path tracking", "times less",
            [](const Line& l) { return measure::inverse(l.row.time).value; }, &PaperRow::tracking)),
        "As the paper's figure 4."}}};
}

report::Figures work_figure(const DepthReport& report) {
  svg::Plot plot{.title = "Work of a sample",
                 .x = {.label = "octree depth"},
                 .y = {.label = "a sample", .logarithmic = true}};
  const auto add = [&](const char* name, double measure::Work::*value) {
    svg::Series s{.name = name, .points = {}};
    for (const Line& l : good_lines(report)) {
      s.points.push_back({.x = double(l.depth.asked), .y = l.row.work.*value});
    }
    plot.series.push_back(s);
  };
  add("look-ups", &measure::Work::lookups);
  add("bounds tests", &measure::Work::bounds_tests);
  add("segments", &measure::Work::segments);
  return {{{svg::draw(plot), "Counted, not timed."}}};
}

// --- JSON ---------------------------------------------------------------------------------------

Json line_json(const Line& l) {
  const Row& r = l.row;
  const measure::Measured& m = r.measured;
  const measure::BuildRatios building = l.building();
  return {{"rounds", m.rounds()},
          {"samples_per_round", m.samples},
          {"bounds_cpu_seconds", measure::median(l.depth.build.bounds)},
          {"tree_cpu_seconds", measure::median(l.depth.build.tree)},
          {"build_ratio", to_json(building.all)},
          {"tree_ratio", to_json(building.tree)},
          {"cpu_seconds_per_sample", measure::median(m.seconds)},
          {"time_ratio", to_json(r.time)},
          {"time_x_variance_ratio", to_json(r.cost)},
          {"lookups_per_sample", r.work.lookups},
          {"bounds_tests_per_sample", r.work.bounds_tests},
          {"segments_per_sample", r.work.segments},
          {"variance_per_sample", r.sample_variance},
          {"relative_rmse_of_one_sample", r.rmse_of_one_sample},
          {"lookups_x_variance", r.lookup_cost()},
          {"lookups_x_variance_ratio", r.lookup_cost() / l.first.lookup_cost()},
          {"instructions_per_sample",
           m.instructions.empty() ? Json() : Json(measure::median(m.instructions))},
          {"relative_bias", r.bias.luminance.relative_bias},
          {"bias_detected", r.detected()}};
}

}  // namespace

std::string depth_text(const DepthRow& row) {
  return row.asked == row.depth ? fmt::format("{}", row.asked)
                                : fmt::format("{} = {}", row.asked, row.depth);
}

report::Document depth_document(const DepthReport& report, bool pictures) {
  const StudyReport& base = report.base;
  report::Document d{.title = "Octree depth: " + base.name,
                     .subject = base.name,
                     .lead = fmt::format("{}; {}", describe(base.loaded), settings_text(base))};
  if (pictures) add(d, paper_figures(report), Shown::on_page);
  add(d, depth_table(report));
  add(d, Text{kPaperLine});
  add(d, notes(base.study));
  add(d, bias_note(report));
  add(d, left_out_lines(base.study), Shown::everywhere);
  if (!pictures) return d;
  add(d, work_figure(report), Shown::on_page);
  const Film& reference = base.study.reference;
  const double exposure = measure::exposure_for_mean(reference);
  add(d,
      lookup_part(good_rows(base.study), "",
                  {{film_image(reference, exposure, "the cloud"), "the reference"}}),
      Shown::on_page);
  return d;
}

Json depth_json(const DepthReport& report) {
  const StudyReport& base = report.base;
  const RenderOptions& o = base.loaded.file.scene.options;
  Json j = scene_json(base);
  j["tracker"] = name(o.tracker);
  j["transmittance"] = name(o.transmittance);
  j["budget_seconds"] = base.budget;
  j["used_seconds"] = base.used;
  j["reference_samples"] = base.study.reference_samples;
  j["false_alarm_rate"] = measure::kFalseAlarms;
  j["depths"] = Json::array();
  for (std::size_t i = 0; i < report.depths.size(); ++i) {
    const DepthRow& depth = report.depths[i];
    const Row& row = base.study.rows[i];
    Json one{{"depth", depth.asked}, {"effective_depth", depth.depth}};
    if (row.good()) {
      one.update(line_json({depth, report.depths[0], row, base.study.rows[0]}));
    } else {
      one["left_out"] = row.measured.left_out;
    }
    j["depths"].push_back(one);
  }
  j["paper"] = Json::array();
  for (const PaperRow& p : kPaper) {
    j["paper"].push_back(
        {{"depth", p.depth}, {"build_ratio", p.build}, {"tracking_ratio", 1 / p.tracking}});
  }
  return j;
}

}  // namespace pvol::cli
