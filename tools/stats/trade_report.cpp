#include "stats/trade_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

using measure::Row;
using measure::Study;
using report::Content;
using report::Heading;
using report::Shown;
using report::Text;

// --- words --------------------------------------------------------------------------------------

std::string goal_text(const measure::Goal& g) {
  return g.error ? fmt::format("for a relative error of {:.4g} %", 100 * *g.error)
                 : fmt::format("in {} of CPU time", readable_seconds(*g.seconds));
}

/// Three significant digits, never in powers of ten for what ratios are.
std::string ratio(double v) { return fmt::format("{:.{}f}", v, v < 9.995 ? 2 : v < 99.95 ? 1 : 0); }

std::string with_interval(const measure::Estimate& e) {
  return fmt::format("{} ({}-{})", ratio(e.value), ratio(e.low), ratio(e.high));
}

std::string bias_text(const Row& row) {
  const measure::ChannelComparison& c = row.bias.luminance;
  const double percent = 100 / c.mean_b;
  if (!std::isfinite(percent)) return "-";
  return fmt::format("{:+.2f} +- {:.2f} %", c.bias * percent,
                     c.bias_half_width * std::abs(percent));
}

/// What the intervals of the table hold, and how often it is wrong.
std::vector<Content> notes(const Study& study) {
  const measure::Coverage c = measure::coverage(study);
  return {Text{fmt::format(
              "Ratios to the default: medians of at least {} rounds, in which the settings took "
              "turns; intervals contain the median with a probability of at least {:.0f} %.",
              c.rounds, 100 * c.probability)},
          Text{fmt::format(
              "Bias: against {} samples per pixel of the default, with 95 % intervals. The "
              "probability that any unbiased setting of the table is called biased is {:.0f} %.",
              study.reference_samples, 100 * measure::kFalseAlarms)},
          Text{fmt::format("Look-ups: per sample. {}", study.rows[0].instructions
                                                           ? "Instructions are in --json."
                                                           : "Instructions: not counted on this "
                                                             "machine.")}};
}

// --- parts --------------------------------------------------------------------------------------

report::Table trade_table(const Study& study) {
  report::Table t{.caption = "Ratios to the default with their intervals; look-ups per sample.",
                  .header = {"setting", "time", "variance", "time x variance", "look-ups", "bytes",
                             "bias of the mean"},
                  .marks =
                      "on the Pareto front of time x variance, systematic error, and bytes in "
                      "memory and file; the default stands for settings that noise does not "
                      "tell from it"};
  for (const Row* r : good_rows(study)) {
    if (r->on_front) t.marked.push_back(t.rows.size());
    t.rows.push_back({label(r->variant), with_interval(r->time), ratio(r->variance.value),
                      with_interval(r->cost), fmt::format("{:.4g}", r->work.lookups),
                      readable_bytes(r->measured.set_up.bytes()), bias_text(*r)});
  }
  return t;
}

std::vector<Content> verdicts(const Study& study) {
  std::vector<Content> list;
  for (const Row* r : good_rows(study)) {
    const std::string text = verdict_text(*r);
    if (text.empty()) continue;
    list.push_back(report::Verdict{fmt::format("{}: {}", label(r->variant), text),
                                   r->detected() ? report::Mood::bad : report::Mood::plain});
  }
  return list;
}

/// With this a page begins and a terminal ends.
std::vector<Content> advice_part(const StudyReport& report) {
  std::vector<Content> part{Heading{"Commands"}};
  for (const measure::Goal& g : report.study.goals) {
    part.push_back(report::Verdict{advice_text(report, g), report::Mood::plain,
                                   g.advice ? command_line(report, *g.advice) : ""});
  }
  return part;
}

bool any_wrongly_biased(const Study& study) {
  return std::any_of(study.rows.begin(), study.rows.end(),
                     [](const Row& r) { return r.good() && r.detected() && !r.variant.biased; });
}

/// The rows whose look-ups a page shows.
std::vector<const Row*> rows_of_interest(const Study& study) {
  constexpr std::size_t kMost = 6;
  std::vector<const Row*> rows = good_rows(study);
  std::erase_if(rows, [&](const Row* r) {
    const std::string& factor = r->variant.factor;
    return r != &study.rows.front() && factor != "tracker" && factor != "micro-bounds";
  });
  if (rows.size() > kMost) rows.resize(kMost);
  return rows;
}

}  // namespace

std::string command_line(const StudyReport& report, const measure::Advice& advice) {
  return render_command(report, report.study.rows[advice.setting].variant.option, advice.samples);
}

std::string advice_text(const StudyReport& report, const measure::Goal& g) {
  if (!g.advice) {
    return fmt::format("{}: no setting measured reaches that{}", goal_text(g),
                       g.error ? " error" : ": one sample per pixel takes longer");
  }
  const Row& row = report.study.rows[g.advice->setting];
  const std::string bias =
      fmt::format(", of which up to {:.4g} % is bias that remains", 100 * row.offset());
  return fmt::format("{}, {}x{} pixels: about {} of CPU time, relative error {:.4g} %{}",
                     goal_text(g), report.loaded.picture_width, report.loaded.picture_height,
                     readable_seconds(g.advice->seconds), 100 * g.advice->error,
                     row.offset() > 0 ? bias : "");
}

std::string verdict_text(const Row& row) {
  if (!row.detected()) return row.variant.biased ? "biased by design, not detected" : "";
  const measure::ChannelComparison& c = row.bias.luminance;
  const bool by_place = std::abs(c.bias) <= c.bias_half_width;
  return fmt::format(
      "BIASED: mean {}{}{}", bias_text(row),
      by_place ? fmt::format(", by place: {:.2g} % or less", 100 * row.offset()) : "",
      row.variant.biased ? "" : ", which is an error of pvol: please report it");
}

report::Document trade_document(const StudyReport& report, bool pictures) {
  const Study& study = report.study;
  report::Document d{.title = "Speed and accuracy: " + report.name,
                     .subject = report.name,
                     .lead = describe(report.loaded)};
  add(d,
      Text{fmt::format("Measured in {} of a budget of {}.", readable_seconds(report.used),
                       readable_seconds(report.budget))},
      Shown::on_page);
  add(d, advice_part(report), Shown::on_page);
  add(d, Heading{"The trade"});
  if (pictures) add(d, trade_plots(report), Shown::on_page);
  add(d, trade_table(study));
  add(d, notes(study), Shown::everywhere);
  if (pictures) add(d, ratio_parts(study), Shown::on_page);
  add(d, Heading{"Bias"});
  add(d, verdicts(study), Shown::everywhere);
  if (!any_wrongly_biased(study)) {
    add(d, report::Verdict{"No unbiased setting was found biased.", report::Mood::good},
        Shown::on_page);
  }
  if (pictures) add(d, bias_parts(study), Shown::on_page);
  const std::vector<Content> left_out = left_out_lines(study);
  if (!left_out.empty()) add(d, Heading{"Left out"}, Shown::on_page);
  add(d, left_out, Shown::everywhere);
  add(d, advice_part(report), Shown::on_terminal);
  if (pictures) add(d, lookup_part(rows_of_interest(study), "", {}), Shown::on_page);
  return d;
}

}  // namespace pvol::cli
