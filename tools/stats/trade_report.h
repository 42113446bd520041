// The trade of speed for accuracy as measured: what the text, JSON and HTML of pvol-stats trade
// show.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/json.h"
#include "pvol/measure/compare.h"
#include "pvol/measure/trade.h"
#include "stats/trade_variants.h"

namespace pvol::cli {

/// Probability that a report calls any setting biased that is not.
inline constexpr double kTradeFalseAlarms = 0.01;

/// One setting with its figures relative to the default.
struct TradeRow {
  Variant variant;
  measure::Measured measured;
  // Where it was measured:
  measure::Estimate time, variance, cost;  ///< ratios to the default's; cost: time x variance
  std::optional<measure::Estimate> instructions;  ///< a sample, of the default's
  measure::FilmComparison bias;                   ///< against the reference
  std::uint64_t file_bytes = 0;                   ///< of a .pvol file that holds the clouds so
  bool on_front = false;
  measure::Setting setting;  ///< for advice
  [[nodiscard]] bool good() const { return measured.left_out.empty(); }
  /// Root of the mean squared systematic error over the reference's mean luminance, as far as its
  /// interval allows it to be; 0 for settings without bias.
  [[nodiscard]] double offset() const;
  /// Time x variance for the front: a hair above the default's where noise does not tell the two
  /// apart, so that the default stands for all that are like it.
  [[nodiscard]] double proven_cost() const;
  [[nodiscard]] bool detected() const { return bias.verdict && bias.verdict->detected; }
};

/// What a picture is to reach: an error or a time.
struct Goal {
  std::optional<double> error{};            ///< root mean squared, over the mean luminance
  std::optional<double> seconds{};          ///< of CPU time
  std::optional<measure::Advice> advice{};  ///< its setting is the number of a row
};

struct TradeReport {
  LoadedScene loaded;
  std::string name;                ///< of the input
  std::vector<std::string> given;  ///< words of the command line that describe the scene
  double budget = 0, used = 0;     ///< seconds of the clock
  double level = 0;                ///< of each test for bias
  Film reference;
  double reference_mean = 0;            ///< luminance
  std::uint32_t reference_samples = 0;  ///< a pixel
  std::vector<TradeRow> rows;           ///< the default first
  std::vector<Goal> goals;
};

/// Puts the default's row first and compares the others with it.
[[nodiscard]] std::vector<TradeRow> make_rows(const std::vector<Variant>& variants,
                                              std::vector<measure::Measured> measured);

/// Tests every row against the reference, all together at the level of `kTradeFalseAlarms`.
void test_biases(TradeReport& report);

/// The same, and finds the front and a setting for each goal.
void judge(TradeReport& report);

/// The command line that renders with a row's setting.
[[nodiscard]] std::string command_line(const TradeReport& report, const measure::Advice& advice);

/// The advice in a sentence, or why there is none.
[[nodiscard]] std::string advice_text(const TradeReport& report, const Goal& goal);

/// "default" or the option.
[[nodiscard]] std::string label(const Variant& variant);

/// The table, cell by cell, for text and page alike.
[[nodiscard]] std::vector<std::string> trade_header();
[[nodiscard]] std::vector<std::string> trade_cells(const TradeRow& row);
/// "BIASED: mean -4.10 +- 0.31 %"; empty for an unbiased setting that was not caught.
[[nodiscard]] std::string verdict_text(const TradeRow& row);
/// What the intervals of the table hold, and how often it is wrong.
[[nodiscard]] std::string coverage_text(const TradeReport& report);
[[nodiscard]] std::string bias_note(const TradeReport& report);

void print_trade(const TradeReport& report);
[[nodiscard]] Json trade_json(const TradeReport& report);
void write_trade_page(const std::filesystem::path& file, const TradeReport& report);

}  // namespace pvol::cli
