#include "stats/trade_report.h"

#include <algorithm>
#include <cmath>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

double median(const std::vector<double>& values) { return measure::estimate_median(values).value; }

/// The ratio where the default varies, and 1 where nothing does.
void relate(TradeRow& row, const TradeRow& base) {
  const measure::Measured &m = row.measured, &b = base.measured;
  row.time = measure::estimate_ratio(m.seconds, b.seconds);
  row.variance = measure::estimate_ratio(m.variance, b.variance);
  const auto products = [](const measure::Measured& of) {
    std::vector<double> p;
    for (std::size_t i = 0; i < of.seconds.size(); ++i) p.push_back(of.seconds[i] * of.variance[i]);
    return p;
  };
  row.cost = measure::estimate_ratio(products(m), products(b));
  if (!m.instructions.empty() && !b.instructions.empty()) {
    row.instructions = measure::estimate_ratio(m.instructions, b.instructions);
  }
}

/// In units of the reference's mean luminance. Time and variance are the default's times the ratios
/// measured in turn, so that a busy spell of the machine favours none.
measure::Setting setting_of(const TradeRow& row, const TradeRow& base, double mean) {
  measure::Setting s;
  s.seconds = median(base.measured.seconds) * row.time.value;
  s.set_up = median(row.measured.set_up_seconds);
  s.variance = measure::sample_variance(base.measured.film) / (mean * mean) * row.variance.value;
  s.offset = row.offset() * row.offset();
  const double cost = row.time.value * row.variance.value;
  if (&row != &base && cost > 0) s.doubt = std::max(1.0, row.cost.high / cost);
  return s;
}

/// In memory and in the file.
double bytes_of(const TradeRow& row) {
  return double(row.measured.set_up.bytes()) + double(row.file_bytes);
}

/// Words with what a shell would split or expand in quotes.
std::string quoted(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string goal(const Goal& g) {
  return g.error ? "for a relative error of " + readable(100 * *g.error) + " %"
                 : "in " + readable_seconds(*g.seconds) + " of CPU time";
}

}  // namespace

double TradeRow::offset() const {
  if (!variant.biased && !detected()) return 0;
  const measure::ChannelComparison& c = bias.luminance;
  const double spread = c.systematic_half_width, mean = std::abs(c.mean_b);
  const double squared = c.systematic_mse + (std::isfinite(spread) ? spread : 0);
  // The mean's own bias is part of the systematic error, and known better.
  return mean > 0 ? std::max(std::sqrt(std::max(0.0, squared)), std::abs(c.bias)) / mean : 0;
}

double TradeRow::proven_cost() const {
  constexpr double kHair = 1e-9;
  if (variant.option.empty()) return 1;
  return cost.low <= 1 && cost.high >= 1 ? 1 + kHair : cost.value;
}

std::vector<TradeRow> make_rows(const std::vector<Variant>& variants,
                                std::vector<measure::Measured> measured) {
  std::vector<TradeRow> rows(variants.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].variant = variants[i];
    rows[i].measured = std::move(measured[i]);
    if (rows[i].good()) relate(rows[i], rows[0]);
  }
  return rows;
}

void test_biases(TradeReport& report) {
  std::size_t tests = 0;
  for (const TradeRow& row : report.rows) tests += row.good();
  report.level = measure::sidak_level(kTradeFalseAlarms, tests);
  for (TradeRow& row : report.rows) {
    if (!row.good()) continue;
    row.bias = measure::compare(row.measured.film, report.reference, {.level = report.level});
  }
}

void judge(TradeReport& report) {
  test_biases(report);
  std::vector<std::size_t> good;
  std::vector<measure::Costs> costs;
  std::vector<measure::Setting> settings;
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    TradeRow& row = report.rows[i];
    if (!row.good()) continue;
    row.setting = setting_of(row, report.rows[0], report.reference_mean);
    good.push_back(i);
    settings.push_back(row.setting);
    // Less than a per cent of the bytes is no reason to choose a setting.
    const double bytes = std::round(100 * bytes_of(row) / bytes_of(report.rows[0]));
    costs.push_back({row.proven_cost(), row.offset(), bytes});
  }
  for (const std::size_t i : measure::pareto_front(costs)) report.rows[good[i]].on_front = true;
  const double pixels = double(report.loaded.picture_width) * report.loaded.picture_height;
  for (Goal& g : report.goals) {
    g.advice = g.error ? measure::advise_for_error(settings, pixels, *g.error)
                       : measure::advise_for_time(settings, pixels, *g.seconds);
    if (g.advice) g.advice->setting = good[g.advice->setting];
  }
}

std::string label(const Variant& variant) {
  return variant.option.empty() ? "default" : variant.option;
}

std::string command_line(const TradeReport& report, const measure::Advice& advice) {
  std::string text = "pvol-render " + quoted(report.name);
  for (const std::string& word : report.given) text += ' ' + quoted(word);
  const std::string& option = report.rows[advice.setting].variant.option;
  if (!option.empty()) text += ' ' + option;
  const auto samples = std::uint32_t(std::min(advice.samples, 4294967295.0));
  return text + " --spp " + std::to_string(samples) + " -o picture.exr";
}

std::string advice_text(const TradeReport& report, const Goal& g) {
  if (!g.advice) {
    return goal(g) + ": no setting measured reaches that" +
           (g.error ? " error" : ": one sample a pixel takes longer");
  }
  const measure::Advice& a = *g.advice;
  const TradeRow& row = report.rows[a.setting];
  std::string text = goal(g) + ", " + std::to_string(report.loaded.picture_width) + "x" +
                     std::to_string(report.loaded.picture_height) + " pixels: about " +
                     readable_seconds(a.seconds) + " of CPU time, relative error " +
                     readable(100 * a.error) + " %";
  if (row.offset() > 0) {
    text += ", of which up to " + readable(100 * row.offset()) + " % is bias that stays";
  }
  return text;
}

}  // namespace pvol::cli
