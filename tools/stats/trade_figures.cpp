// What the report of pvol-stats trade draws.
#include <fmt/format.h>

#include <algorithm>

#include "pvol/measure/pixel_maps.h"
#include "report/film_pictures.h"
#include "report/ratio_bars.h"
#include "report/svg.h"
#include "stats/trade_report.h"

namespace pvol::cli {
namespace {

using measure::Row;
using measure::Study;

/// Systematic error against the cost of getting rid of noise. A logarithm has no place for 0: the
/// unbiased stand at the bottom.
svg::Plot front_plot(const Study& study) {
  constexpr double kBottom = 0.1;  // per cent, and no more than half of what is above it
  const std::vector<const Row*> rows = good_rows(study);
  double bottom = kBottom;
  for (const Row* r : rows) {
    if (r->offset() > 0) bottom = std::min(bottom, 50 * r->offset());
  }
  std::vector<measure::Costs> costs;
  for (const Row* r : rows) {
    costs.push_back({r->proven_cost(), std::max(100 * r->offset(), bottom), 0});
  }
  const std::vector<std::size_t> best = measure::pareto_front(costs);
  svg::Series unbiased{
      .name = "unbiased: 0", .points = {}, .style = svg::Style::points, .colour = 0};
  svg::Series biased{.name = "biased", .points = {}, .style = svg::Style::points, .colour = 1};
  svg::Series front{.name = "front", .points = {}, .style = svg::Style::steps, .colour = 6};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool on_front = std::find(best.begin(), best.end(), i) != best.end();
    const svg::Point point{.x = rows[i]->cost.value, .y = costs[i][1]};
    if (on_front) front.points.push_back(point);
    std::vector<svg::Point>& points = (rows[i]->variant.biased ? biased : unbiased).points;
    points.push_back(point);
    if (i == 0 || on_front) points.back().label = label(rows[i]->variant);
  }
  std::sort(front.points.begin(), front.points.end(),
            [](const svg::Point& a, const svg::Point& b) { return a.x < b.x; });
  return {
      .title = "Cost and systematic error",
      .x = {.label = "time x variance, over the default's", .logarithmic = true},
      .y = {.label = "systematic error at most, % of the mean", .logarithmic = true, .lo = bottom},
      .series = {front, unbiased, biased}};
}

/// Error against time: noise falls with the root of time, bias stays.
svg::Plot convergence_plot(const StudyReport& report) {
  constexpr std::size_t kMost = 8;  // curves that can be told apart
  const Study& study = report.study;
  svg::Plot plot{.title = fmt::format("Error of a picture of {}x{} pixels",
                                      report.loaded.picture_width, report.loaded.picture_height),
                 .x = {.label = "CPU time, s", .logarithmic = true},
                 .y = {.label = "relative error, %", .logarithmic = true}};
  std::vector<const Row*> shown{&study.rows.front()};
  for (const Row* r : good_rows(study)) {
    if (r->on_front && r != shown.front() && shown.size() < kMost) shown.push_back(r);
  }
  for (const Row* r : shown) {
    svg::Series s{.name = label(r->variant), .points = {}, .dashed = r->variant.biased};
    for (double samples = 1; samples <= 1 << 16; samples *= 2) {
      const measure::Advice a = measure::forecast(r->setting, study.picture_pixels, samples);
      s.points.push_back({.x = a.seconds, .y = 100 * a.error});
    }
    plot.series.push_back(s);
  }
  return plot;
}

report::Figures bars(const Study& study, const char* title, measure::Estimate Row::*ratio) {
  std::vector<svg::RatioBar> list;
  for (const Row* r : good_rows(study)) {
    if (r == &study.rows.front() || !((r->*ratio).low > 0)) continue;
    list.push_back({label(r->variant), r->*ratio, r->variant.biased});
  }
  return {{{svg::draw_ratios(title, list), ""}}};
}

}  // namespace

report::Figures trade_plots(const StudyReport& report) {
  return {{{svg::draw(front_plot(report.study)),
            "Settings to the left are cheaper, lower ones are more accurate. Systematic error: the "
            "largest that the interval of its measurement allows."},
           {svg::draw(convergence_plot(report)),
            "The default and the settings on the front; dashed ones are biased and level off."}}};
}

std::vector<report::Content> ratio_parts(const Study& study) {
  return {bars(study, "CPU time of a sample, over the default's", &Row::time),
          bars(study, "Variance of a sample, over the default's", &Row::variance),
          bars(study, "Time x variance, over the default's", &Row::cost)};
}

std::vector<report::Content> bias_parts(const Study& study) {
  const double exposure = measure::exposure_for_mean(study.reference);
  std::vector<report::Content> parts;
  for (const Row* r : good_rows(study)) {
    if (!r->variant.biased || r->variant.factor.find('+') != std::string::npos) continue;
    const double full = std::max(0.02, 2 * r->offset());
    const Film& film = r->measured.film;
    const std::string name = label(r->variant);
    parts.push_back(report::Figures{
        {{film_image(study.reference, exposure, "the reference"), "the default"},
         {film_image(film, exposure, name), name},
         {difference_image(film, study.reference, full * study.reference_mean, "difference"),
          fmt::format("difference in blocks of 4 x 4 pixels: blue is darker, orange brighter, full "
                      "at {:.4g} % of the mean",
                      100 * full)}}});
  }
  return parts;
}

}  // namespace pvol::cli
