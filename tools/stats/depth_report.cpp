#include "stats/depth_report.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "cli/cli.h"
#include "cli/columns.h"
#include "report/film_pictures.h"
#include "report/html.h"
#include "report/svg.h"

namespace pvol::cli {
namespace {

/// Probability that any depth is called biased though none is.
constexpr double kFalseAlarms = 0.01;

/// Table 1 of the paper, against no octree.
struct PaperRow {
  int depth;
  double build, tracking;  ///< building grows, tracking falls by this factor
};
constexpr PaperRow kPaper[] = {{4, 4.92, 4.34}, {8, 11.47, 20.42}, {16, 14.31, 19.02}};
constexpr const char* kPaperLine =
    "The paper's table 1, against no octree, at depths 4 / 8 / 16: building takes 4.92 / 11.47 / "
    "14.31 times as long, tracking 4.34 / 20.42 / 19.02 times less.";

std::vector<double> products(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> p;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) p.push_back(a[i] * b[i]);
  return p;
}

std::vector<double> sums(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> s;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) s.push_back(a[i] + b[i]);
  return s;
}

/// n x (MSE - what the reference's own noise adds), over the reference's mean.
double rmse_of_one_sample(const measure::FilmComparison& c, const Film& film,
                          const Film& reference) {
  double noise = 0;
  for (const PixelSums& p : reference.pixels) {
    noise += measure::luminance_deviation(p) * measure::luminance_deviation(p) /
             double(reference.pixels.size());
  }
  const double n = film.pixels.front().samples;
  return std::sqrt(std::max(0.0, n * (c.luminance.mse - noise))) / std::abs(c.luminance.mean_b);
}

void relate(DepthRow& row, const DepthRow& base, const Film& reference, double level) {
  const measure::Measured& m = row.measured;
  row.build_ratio = measure::estimate_ratio(sums(row.build.bounds, row.build.tree),
                                            sums(base.build.bounds, base.build.tree));
  row.tree_ratio = measure::estimate_ratio(row.build.tree, base.build.tree);
  row.time = measure::estimate_ratio(m.seconds, base.measured.seconds);
  row.cost = measure::estimate_ratio(products(m.seconds, m.variance),
                                     products(base.measured.seconds, base.measured.variance));
  const Counts& k = m.counts;
  const double n = double(m.counted);
  row.lookups = double(k.lookups_path + k.lookups_shadow) / n;
  row.tests = double(k.bounds_tests_path + k.bounds_tests_shadow) / n;
  row.segments = double(k.segments_path + k.segments_shadow) / n;
  row.bias = measure::compare(m.film, reference, {.level = level});
  row.rmse = rmse_of_one_sample(row.bias, m.film, reference);
  row.lookup_cost = row.lookups * measure::sample_variance(m.film);
}

double median(const std::vector<double>& v) {
  return v.empty() ? 0 : measure::estimate_median(v).value;
}

/// How many times less than the base: the ratio upside down.
measure::Estimate inverse(const measure::Estimate& e) {
  return {1 / e.value, 1 / e.high, 1 / e.low, e.coverage};
}

std::string with_interval(const measure::Estimate& e) {
  return formatted("%.2f", e.value) + " (" + formatted("%.2f", e.low) + "-" +
         formatted("%.2f", e.high) + ")";
}

std::string depth_text(const DepthRow& row) {
  return row.asked == row.depth ? std::to_string(row.asked)
                                : std::to_string(row.asked) + " = " + std::to_string(row.depth);
}

const std::vector<std::string> kHeader{"depth",
                                       "bounds",
                                       "tree",
                                       "built x",
                                       "us/sample",
                                       "tracking less by",
                                       "look-ups",
                                       "tests",
                                       "segm.",
                                       "RMSE 1 spp",
                                       "look-ups x var less by",
                                       "time x var less by"};

std::vector<std::string> cells(const DepthRow& row, const DepthRow& base) {
  return {depth_text(row),
          readable_seconds(median(row.build.bounds)),
          readable_seconds(median(row.build.tree)),
          formatted("%.2f", row.build_ratio.value),
          formatted("%.3g", 1e6 * median(row.measured.seconds)),
          with_interval(inverse(row.time)),
          formatted("%.4g", row.lookups),
          formatted("%.4g", row.tests),
          formatted("%.4g", row.segments),
          formatted("%.3g", row.rmse),
          formatted("%.2f", base.lookup_cost / row.lookup_cost),
          formatted("%.2f", 1 / row.cost.value)};
}

std::string settings_text(const DepthReport& report) {
  const RenderOptions& o = report.loaded.file.scene.options;
  return std::string("tracker ") + formats::name(o.tracker) + ", shadow rays " +
         formats::name(o.transmittance) + ", micro-bounds " + formats::name(o.micro_bounds) +
         " at every depth";
}

std::string notes(const DepthReport& report) {
  double least = 1;
  for (const DepthRow& r : report.rows) {
    if (r.good()) least = std::min(least, r.time.coverage);
  }
  return "Factors against the first row: medians over rounds in which the depths took turns; "
         "intervals hold the median with " +
         formatted("%.0f", 100 * least) +
         " % or more. bounds: from all voxels, alike for every depth; tree: bricks and octree. "
         "RMSE: over the mean, against " +
         std::to_string(report.reference.pixels.front().samples) + " samples a pixel.";
}

std::string bias_note(const DepthReport& report) {
  std::string biased;
  for (const DepthRow& r : report.rows) {
    if (r.good() && r.bias.verdict && r.bias.verdict->detected) {
      biased += (biased.empty() ? "" : ", ") + std::to_string(r.asked);
    }
  }
  return biased.empty() ? "No depth differs from the reference beyond noise."
                        : "BIASED, though none should be; please report this: depth " + biased;
}

}  // namespace

void relate(DepthReport& report) {
  std::size_t tests = 0;
  for (const DepthRow& r : report.rows) tests += r.good();
  const double level = measure::sidak_level(kFalseAlarms, tests);
  for (DepthRow& r : report.rows) {
    if (r.good()) relate(r, report.rows.front(), report.reference, level);
  }
}

void print_depth(const DepthReport& report) {
  static constexpr std::size_t kWidths[] = {7, 8, 8, 9, 11, 19, 10, 8, 8, 12, 24, 20};
  const auto print = [&](const std::vector<std::string>& row, std::size_t begin, std::size_t end) {
    std::cout << left_in(row[0], kWidths[0]);
    for (std::size_t i = begin; i < end; ++i) std::cout << right_in(row[i], kWidths[i]);
    std::cout << '\n';
  };
  std::cout << wrapped(report.name + ": " + describe(report.loaded) + "; " + settings_text(report));
  // Two tables side by side would be wider than a terminal.
  constexpr std::size_t kSplit = 6;
  for (const auto& [begin, end] : {std::pair<std::size_t, std::size_t>{1, kSplit}, {kSplit, 12}}) {
    std::cout << '\n';
    print(kHeader, begin, end);
    for (const DepthRow& r : report.rows) {
      if (r.good()) print(cells(r, report.rows.front()), begin, end);
    }
  }
  std::cout << '\n' << wrapped(kPaperLine) << wrapped(notes(report)) << wrapped(bias_note(report));
  for (const DepthRow& r : report.rows) {
    if (!r.good()) {
      std::cout << wrapped("depth " + std::to_string(r.asked) +
                           ": left out: " + r.measured.left_out);
    }
  }
}

// --- JSON ---------------------------------------------------------------------------------------

namespace {

Json to_json(const measure::Estimate& e) {
  return {{"value", e.value}, {"low", e.low}, {"high", e.high}, {"coverage", e.coverage}};
}

Json to_json(const DepthRow& r, const DepthRow& base) {
  const measure::Measured& m = r.measured;
  Json j{{"depth", r.asked}, {"effective_depth", r.depth}};
  if (!r.good()) {
    j["left_out"] = m.left_out;
    return j;
  }
  j["rounds"] = m.rounds();
  j["samples_per_round"] = m.samples;
  j["bounds_cpu_seconds"] = median(r.build.bounds);
  j["tree_cpu_seconds"] = median(r.build.tree);
  j["build_ratio"] = to_json(r.build_ratio);
  j["tree_ratio"] = to_json(r.tree_ratio);
  j["cpu_seconds_per_sample"] = median(m.seconds);
  j["time_ratio"] = to_json(r.time);
  j["time_x_variance_ratio"] = to_json(r.cost);
  j["lookups_per_sample"] = r.lookups;
  j["bounds_tests_per_sample"] = r.tests;
  j["segments_per_sample"] = r.segments;
  j["variance_per_sample"] = measure::sample_variance(m.film);
  j["relative_rmse_of_one_sample"] = r.rmse;
  j["lookups_x_variance"] = r.lookup_cost;
  j["lookups_x_variance_ratio"] = r.lookup_cost / base.lookup_cost;
  j["instructions_per_sample"] = m.instructions.empty() ? Json() : Json(median(m.instructions));
  j["relative_bias"] = r.bias.luminance.relative_bias;
  j["bias_detected"] = r.bias.verdict && r.bias.verdict->detected;
  return j;
}

}  // namespace

Json depth_json(const DepthReport& report) {
  const RenderOptions& o = report.loaded.file.scene.options;
  Json j{{"file", report.name},
         {"extinction", report.loaded.file.scene.medium.extinction},
         {"mean_optical_thickness", report.loaded.facts.front().mean_optical_thickness},
         {"size", {o.width, o.height}},
         {"tracker", formats::name(o.tracker)},
         {"transmittance", formats::name(o.transmittance)},
         {"budget_seconds", report.budget},
         {"used_seconds", report.used},
         {"reference_samples", report.reference.pixels.front().samples},
         {"false_alarm_rate", kFalseAlarms}};
  j["depths"] = Json::array();
  for (const DepthRow& r : report.rows) j["depths"].push_back(to_json(r, report.rows.front()));
  j["paper"] = Json::array();
  for (const PaperRow& p : kPaper) {
    j["paper"].push_back(
        {{"depth", p.depth}, {"build_ratio", p.build}, {"tracking_ratio", 1 / p.tracking}});
  }
  return j;
}

// --- the page -----------------------------------------------------------------------------------

namespace {

/// A figure of the paper with ours beside it.
svg::Plot figure(const DepthReport& report, const char* title, const char* axis,
                 double (*ours)(const DepthRow&), double PaperRow::*theirs) {
  constexpr double kHalf = 0.7;  // of a pair of bars, in depths
  svg::Plot plot{.title = title, .x = {.label = "octree depth"}, .y = {.label = axis}};
  svg::Bars mine{.name = "this cloud", .bars = {}, .colour = 0},
      paper{.name = "the paper's", .bars = {}, .colour = 1};
  for (const DepthRow& r : report.rows) {
    if (r.good()) mine.bars.push_back({r.asked - kHalf, double(r.asked), ours(r)});
  }
  for (const PaperRow& p : kPaper)
    paper.bars.push_back({double(p.depth), p.depth + kHalf, p.*theirs});
  plot.bars = {mine, paper};
  return plot;
}

svg::Plot counts_plot(const DepthReport& report) {
  svg::Plot plot{.title = "Work of a sample",
                 .x = {.label = "octree depth"},
                 .y = {.label = "a sample", .logarithmic = true}};
  const auto add = [&](const char* name, double DepthRow::*value) {
    svg::Series s{.name = name, .points = {}};
    for (const DepthRow& r : report.rows) {
      if (r.good()) s.points.push_back({.x = double(r.asked), .y = r.*value});
    }
    plot.series.push_back(s);
  };
  add("look-ups", &DepthRow::lookups);
  add("bounds tests", &DepthRow::tests);
  add("segments", &DepthRow::segments);
  return plot;
}

}  // namespace

void write_depth_page(const std::filesystem::path& file, const DepthReport& report) {
  html::Page page;
  page.title = "Octree depth: " + report.name;
  html::add_paragraph(page, describe(report.loaded) + "; " + settings_text(report) + '.');
  const std::vector<html::Figure> figures{
      {svg::draw(figure(
           report, "Increase in the calculation time of the octree",
           "times that of the first depth", [](const DepthRow& r) { return r.build_ratio.value; },
           &PaperRow::build)),
       "As the paper's figure 3. Bounds are made of all voxels whatever the depth, so building "
       "hardly depends on it here."},
      {svg::draw(figure(
           report, "Decrease in the calculation time of path tracking", "times less",
           [](const DepthRow& r) { return 1 / r.time.value; }, &PaperRow::tracking)),
       "As the paper's figure 4."}};
  html::add_figures(page, figures);
  html::Table table{.caption = "One row for each depth; the first is the base of all factors",
                    .header = kHeader,
                    .rows = {},
                    .marked = {}};
  for (const DepthRow& r : report.rows) {
    if (r.good()) table.rows.push_back(cells(r, report.rows.front()));
  }
  html::add_table(page, table);
  html::add_paragraph(page, kPaperLine);
  html::add_paragraph(page, notes(report) + ' ' + bias_note(report));
  html::add_figure(page, {svg::draw(counts_plot(report)), "Counted, not timed."});

  html::add_heading(page, "Where the density is looked up");
  double most = 0;
  for (const DepthRow& r : report.rows) {
    if (r.good()) most = std::max(most, most_lookups(r.measured.counted_film));
  }
  const double exposure = choose_exposure(report.reference);
  std::vector<html::Figure> maps{
      {film_image(report.reference, exposure, "the cloud"), "the reference"}};
  for (const DepthRow& r : report.rows) {
    if (!r.good()) continue;
    maps.push_back(
        {lookup_image(r.measured.counted_film, most, "look-ups at depth " + depth_text(r)),
         "depth " + depth_text(r) + ": " + readable(most_lookups(r.measured.counted_film)) +
             " look-ups a sample at most"});
  }
  html::add_figures(page, maps);
  html::write_page(file, page);
}

}  // namespace pvol::cli
