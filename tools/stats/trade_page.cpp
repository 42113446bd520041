// The report of pvol-stats trade as a page.
#include <algorithm>
#include <cmath>

#include "cli/cli.h"
#include "report/film_pictures.h"
#include "report/html.h"
#include "report/ratio_bars.h"
#include "report/svg.h"
#include "stats/trade_report.h"

namespace pvol::cli {
namespace {

/// Rows that were measured, in order.
std::vector<const TradeRow*> good_rows(const TradeReport& report) {
  std::vector<const TradeRow*> rows;
  for (const TradeRow& r : report.rows) {
    if (r.good()) rows.push_back(&r);
  }
  return rows;
}

void add_advice(html::Page& page, const TradeReport& report) {
  html::add_heading(page, "What to type");
  for (const Goal& g : report.goals) {
    std::string text = advice_text(report, g);
    if (g.advice) text += ":  " + command_line(report, *g.advice);
    html::add_verdict(page, text, html::Mood::plain);
  }
}

/// Systematic error against the cost of getting rid of noise. A logarithm has no place for 0: the
/// unbiased stand at the bottom.
svg::Plot front_plot(const TradeReport& report) {
  constexpr double kBottom = 0.1;  // per cent, and no more than half of what is above it
  const std::vector<const TradeRow*> rows = good_rows(report);
  double bottom = kBottom;
  for (const TradeRow* r : rows) {
    if (r->offset() > 0) bottom = std::min(bottom, 50 * r->offset());
  }
  svg::Plot plot;
  plot.title = "Cost and systematic error";
  plot.x = {.label = "time x variance, over the default's", .logarithmic = true};
  plot.y = {.label = "systematic error at most, % of the mean", .logarithmic = true, .lo = bottom};
  svg::Series unbiased{
      .name = "unbiased: 0", .points = {}, .style = svg::Style::points, .colour = 0};
  svg::Series biased{.name = "biased", .points = {}, .style = svg::Style::points, .colour = 1};
  svg::Series front{.name = "front", .points = {}, .style = svg::Style::steps, .colour = 6};
  std::vector<measure::Costs> costs;
  for (const TradeRow* r : rows) {
    costs.push_back({r->proven_cost(), std::max(100 * r->offset(), bottom), 0});
  }
  const std::vector<std::size_t> best = measure::pareto_front(costs);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool named = i == 0 || std::find(best.begin(), best.end(), i) != best.end();
    (rows[i]->variant.biased ? biased : unbiased)
        .points.push_back({.x = rows[i]->cost.value,
                           .y = costs[i][1],
                           .label = named ? label(rows[i]->variant) : std::string()});
  }
  for (const std::size_t i : best) {
    front.points.push_back({.x = rows[i]->cost.value, .y = costs[i][1]});
  }
  std::sort(front.points.begin(), front.points.end(),
            [](const svg::Point& a, const svg::Point& b) { return a.x < b.x; });
  plot.series = {front, unbiased, biased};
  return plot;
}

/// Error against time: noise falls with the root of time, bias stays.
svg::Plot convergence_plot(const TradeReport& report) {
  svg::Plot plot;
  plot.title = "Error of a picture of " + std::to_string(report.loaded.picture_width) + "x" +
               std::to_string(report.loaded.picture_height) + " pixels";
  plot.x = {.label = "CPU time, s", .logarithmic = true};
  plot.y = {.label = "relative error, %", .logarithmic = true};
  const double pixels = double(report.loaded.picture_width) * report.loaded.picture_height;
  constexpr std::size_t kMost = 8;  // curves that can be told apart
  std::vector<const TradeRow*> shown{&report.rows.front()};
  for (const TradeRow* r : good_rows(report)) {
    if (r->on_front && r != shown.front() && shown.size() < kMost) shown.push_back(r);
  }
  for (const TradeRow* r : shown) {
    svg::Series s{.name = label(r->variant), .points = {}, .dashed = r->variant.biased};
    for (double samples = 1; samples <= 1 << 16; samples *= 2) {
      const measure::Setting& m = r->setting;
      s.points.push_back({.x = m.set_up + samples * pixels * m.seconds,
                          .y = 100 * std::sqrt(m.offset + m.variance / samples)});
    }
    plot.series.push_back(s);
  }
  return plot;
}

std::string bars(const TradeReport& report, const std::string& title,
                 measure::Estimate TradeRow::*ratio) {
  std::vector<svg::RatioBar> list;
  for (const TradeRow* r : good_rows(report)) {
    if (r == &report.rows.front() || !((r->*ratio).low > 0)) continue;
    list.push_back({label(r->variant), r->*ratio, r->variant.biased});
  }
  return svg::draw_ratios(title, list);
}

void add_table(html::Page& page, const TradeReport& report) {
  html::Table table{.caption =
                        "Ratios to the default with their intervals; look-ups "
                        "a sample. Rows on the Pareto front of time x variance, systematic "
                        "error and bytes stand out.",
                    .header = trade_header(),
                    .rows = {},
                    .marked = {}};
  for (const TradeRow* r : good_rows(report)) {
    if (r->on_front) table.marked.push_back(table.rows.size());
    table.rows.push_back(trade_cells(*r));
  }
  html::add_table(page, table);
  html::add_paragraph(page, coverage_text(report) + ' ' + bias_note(report));
  std::string left_out;
  for (const TradeRow& r : report.rows) {
    if (!r.good()) left_out += label(r.variant) + ": " + r.measured.left_out + ". ";
  }
  if (!left_out.empty()) html::add_paragraph(page, "Left out: " + left_out);
}

void add_biases(html::Page& page, const TradeReport& report) {
  html::add_heading(page, "Bias");
  bool found = false, wrong = false;
  for (const TradeRow* r : good_rows(report)) {
    const std::string verdict = verdict_text(*r);
    if (verdict.empty()) continue;
    found = true;
    wrong = wrong || (r->detected() && !r->variant.biased);
    html::add_verdict(page, label(r->variant) + ": " + verdict,
                      r->detected() ? html::Mood::bad : html::Mood::plain);
  }
  if (!wrong) {
    html::add_verdict(page, "No setting that should be unbiased was found biased.",
                      html::Mood::good);
  }
  if (!found) return;
  const double exposure = choose_exposure(report.reference);
  const auto percent = [&](double v) { return readable(100 * v) + " %"; };
  for (const TradeRow* r : good_rows(report)) {
    if (!r->variant.biased || r->variant.factor.find('+') != std::string::npos) continue;
    const double full = std::max(0.02, 2 * r->offset());
    const std::vector<html::Figure> figures{
        {film_image(report.reference, exposure, "the reference"), "the default"},
        {film_image(r->measured.film, exposure, label(r->variant)), label(r->variant)},
        {difference_image(r->measured.film, report.reference, full * report.reference_mean,
                          "difference"),
         "difference in blocks of 4 x 4 pixels: blue is darker, orange brighter, full at " +
             percent(full) + " of the mean"}};
    html::add_figures(page, figures);
  }
}

void add_lookups(html::Page& page, const TradeReport& report) {
  html::add_heading(page, "Where the density is looked up");
  constexpr std::size_t kMost = 6;
  std::vector<const TradeRow*> shown;
  double most = 0;
  for (const TradeRow* r : good_rows(report)) {
    const bool of_interest = r == &report.rows.front() || r->variant.factor == "tracker" ||
                             r->variant.factor == "micro-bounds";
    if (!of_interest || shown.size() == kMost) continue;
    shown.push_back(r);
    most = std::max(most, most_lookups(r->measured.counted_film));
  }
  std::vector<html::Figure> figures;
  for (const TradeRow* r : shown) {
    const Film& film = r->measured.counted_film;
    figures.push_back(
        {lookup_image(film, most, "look-ups of " + label(r->variant)),
         label(r->variant) + ": " + readable(most_lookups(film)) + " look-ups a sample at most"});
  }
  html::add_paragraph(page, "Look-ups a sample, by pixel, on one logarithmic scale from 0 to " +
                                readable(most) + ".");
  html::add_figures(page, figures);
}

}  // namespace

void write_trade_page(const std::filesystem::path& file, const TradeReport& report) {
  html::Page page;
  page.title = "Speed and accuracy: " + report.name;
  html::add_paragraph(page, describe(report.loaded) + ". Measured in " +
                                readable_seconds(report.used) + " of a budget of " +
                                readable_seconds(report.budget) + ".");
  add_advice(page, report);
  html::add_heading(page, "The trade");
  const std::vector<html::Figure> plots{
      {svg::draw(front_plot(report)),
       "Left is cheaper, down is truer. Systematic error: as large as the interval of its "
       "measurement allows."},
      {svg::draw(convergence_plot(report)),
       "The default and what is on the front; dashed ones are biased and level off."}};
  html::add_figures(page, plots);
  add_table(page, report);
  for (const auto& [title, ratio] :
       {std::pair{"CPU time of a sample, over the default's", &TradeRow::time},
        std::pair{"Variance of a sample, over the default's", &TradeRow::variance},
        std::pair{"Time x variance, over the default's", &TradeRow::cost}}) {
    html::add_figure(page, {bars(report, title, ratio), ""});
  }
  add_biases(page, report);
  add_lookups(page, report);
  html::write_page(file, page);
}

}  // namespace pvol::cli
