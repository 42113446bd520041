// The verb `trade`: what each option of the renderer costs and gains on the user's own scene.
#include <iomanip>
#include <iostream>
#include <sstream>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/measure/sweep.h"
#include "stats/stats_trade.h"
#include "stats/trade_report.h"

namespace pvol::cli {
namespace {

/// Parts of the budget: the reference, then settings of one factor; combinations get the rest.
constexpr double kReferencePart = 0.2, kSinglesPart = 0.65;

constexpr int kPixels = 96 * 96;

/// A file in a folder of its own, removed at the end.
class ScratchFile {
 public:
  ScratchFile() {
    std::string name = (std::filesystem::temp_directory_path() / "pvol-stats-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw Error(name + ": cannot be made");
    folder_ = name;
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  [[nodiscard]] std::filesystem::path path() const { return folder_ / "cloud.pvol"; }

 private:
  std::filesystem::path folder_;
};

/// Bytes of the .pvol files that hold these clouds with their density.
std::uint64_t file_bytes(const std::vector<formats::Cloud>& clouds, const ChangeCloud& change) {
  const ScratchFile scratch;
  std::uint64_t bytes = 0;
  for (formats::Cloud cloud : clouds) {
    if (change) change(cloud);
    formats::PvolFile file;
    file.metadata = cloud.metadata;
    file.pyramid = cloud.pyramid;
    file.shell = cloud.shell;
    if (cloud.metadata.quantisation.precision != Precision::fp32) {
      file.codes = quantise(cloud.grid, cloud.metadata.quantisation);
    } else if (!cloud.recipe) {
      file.density = cloud.grid;
    }
    file.metadata.grid_name = cloud.grid.name;
    file.metadata.index_to_world = cloud.grid.index_to_world;
    bytes += formats::write_pvol(scratch.path(), file).total;
  }
  return bytes;
}

/// Within `part` seconds of the clock; `after` are left of the budget then.
std::vector<measure::Measured> measure(const TradeReport& report,
                                       const std::vector<Variant>& variants, double part,
                                       double after, std::uint64_t seed, Announcer& announce) {
  measure::SweepOptions o;
  o.budget = part;
  o.seed = seed;
  o.pixels = report.reference.pixels.size();
  o.clock = clock_seconds;
  o.remedy = "raise --budget or lower --size";
  o.interrupted = interrupted;
  o.progress = [&](const std::string& next, double left) { announce(next, left + after); };
  std::vector<std::string> names;
  for (const Variant& v : variants) names.push_back(label(v));
  return measure::sweep(names, o, [&](const measure::RunRequest& r) {
    // One thread: times and instructions are then those of the work alone.
    return render_changed(report.loaded, variants[r.setting].scene, variants[r.setting].cloud, r,
                          1);
  });
}

VariantResult result_of(const TradeRow& row) {
  if (!row.good()) return {};
  return {true, row.cost.value, row.cost.high, row.offset()};
}

/// What the user said of the scene, as pvol-render takes it.
std::vector<std::string> words_of(const SceneOptions& o, const LoadedScene& loaded) {
  std::vector<std::string> words;
  if (!o.grid.grid.empty()) words.insert(words.end(), {"--grid", o.grid.grid});
  for (const std::string& s : o.sets) words.insert(words.end(), {"--set", s});
  if (o.extinction || o.thickness) {
    std::ostringstream number;
    number << std::setprecision(17) << loaded.file.scene.medium.extinction;
    words.insert(words.end(), {"--set", "medium.extinction=" + number.str()});
  }
  return words;
}

std::vector<Goal> goals_of(const TradeOptions& o) {
  if (o.most_error) return {{.error = *o.most_error}};
  if (o.most_time) return {{.seconds = *o.most_time}};
  return {{.error = 0.1}, {.error = 0.03}, {.error = 0.01}};
}

TradeReport measure_trade(const TradeOptions& o) {
  TradeReport report;
  report.loaded = load_scene(o.scene, kPixels);
  const double begin = clock_seconds();
  const auto left = [&] { return o.budget - (clock_seconds() - begin); };
  Announcer announce(o.quiet);
  catch_interrupt();
  report.name = o.scene.input.string();
  report.given = words_of(o.scene, report.loaded);
  report.goals = goals_of(o);
  report.budget = o.budget;
  announce("the reference", left());
  constexpr std::uint64_t kReferenceSeeds = std::uint64_t(1) << 40;  // far from all others
  report.reference =
      render_reference(report.loaded, kReferencePart * left(), kReferenceSeeds, o.threads);
  report.reference_mean = measure::mean_luminance(report.reference);
  report.reference_samples = report.reference.pixels.front().samples;
  if (!(report.reference_mean > 0)) {
    throw Error(report.name + ": the picture is black; there is no error to measure");
  }

  const std::vector<Variant> singles = single_variants(report.loaded);
  std::vector<Variant> variants{default_variant()};
  variants.insert(variants.end(), singles.begin(), singles.end());
  const double part = kSinglesPart / (1 - kReferencePart);
  report.rows = make_rows(
      variants, measure(report, variants, part * left(), (1 - part) * left(), 1, announce));
  test_biases(report);

  std::vector<VariantResult> results;
  for (std::size_t i = 1; i < report.rows.size(); ++i) results.push_back(result_of(report.rows[i]));
  const std::vector<Variant> pairs = combinations(singles, results);
  if (!pairs.empty() && !interrupted()) {
    variants.assign(1, default_variant());
    variants.insert(variants.end(), pairs.begin(), pairs.end());
    constexpr std::uint64_t kCombinationSeeds = std::uint64_t(1) << 20;
    std::vector<TradeRow> rows =
        make_rows(variants, measure(report, variants, left(), 0, kCombinationSeeds, announce));
    for (std::size_t i = 1; i < rows.size(); ++i) report.rows.push_back(std::move(rows[i]));
  }
  const std::uint64_t plain = file_bytes(report.loaded.clouds, {});
  for (TradeRow& row : report.rows) {
    if (!row.good()) continue;
    row.file_bytes =
        row.variant.cloud ? file_bytes(report.loaded.clouds, row.variant.cloud) : plain;
  }
  judge(report);
  report.used = clock_seconds() - begin;
  return report;
}

}  // namespace

void Announcer::operator()(const std::string& next, double seconds_left) {
  constexpr double kPause = 5;
  if (quiet_ || clock_seconds() < last_ + kPause) return;
  last_ = clock_seconds();
  seconds_left = std::max(0.0, seconds_left);
  std::cerr << "pvol-stats: " << next << "; " << readable_seconds(seconds_left) << " left\n";
}

int run_trade(const TradeOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  const TradeReport report = measure_trade(o);
  if (o.html) write_trade_page(*o.html, report);
  if (o.json) {
    std::cout << to_text(trade_json(report));
  } else if (!o.quiet) {
    print_trade(report);
  }
  return kSuccess;
}

}  // namespace pvol::cli
