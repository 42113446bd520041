#include "stats/study_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <utility>

#include "cli/cli.h"
#include "pvol/error.h"

namespace pvol::cli {

StudyClock::StudyClock(StudyReport& report, bool quiet)
    : report_(report), quiet_(quiet), begin_(clock_seconds()) {}

double StudyClock::left() const { return report_.budget - (clock_seconds() - begin_); }

void StudyClock::announce(const std::string& next, double seconds_left) {
  constexpr double kPause = 5;
  const std::string round = next.starts_with("round ") ? next.substr(0, next.find(':')) : "";
  if (quiet_ || (round == round_ && clock_seconds() < last_ + kPause)) return;
  last_ = clock_seconds();
  round_ = round;
  std::cerr << fmt::format("pvol-stats: {}; {} left\n", next,
                           readable_seconds(std::max(0.0, seconds_left)));
}

measure::SweepOptions StudyClock::options(double seconds, std::uint64_t seed) const {
  measure::SweepOptions o;
  o.budget = seconds;
  o.seed = seed;
  o.pixels = report_.study.reference.pixels.size();
  o.clock = clock_seconds;
  o.interrupted = interrupted;
  o.remedy = "raise --budget or lower --size";
  return o;
}

void StudyClock::measure_reference(const LoadedScene& loaded, double part, int threads) {
  announce("the reference");
  Film film = measure::render_reference(
      options(part * left(), kReferenceSeed),
      [&](const measure::RunRequest& r) { return render_changed(loaded, {}, {}, r, threads); });
  naming(report_.name, [&] { measure::set_reference(report_.study, std::move(film)); });
  report_.saves = std::make_unique<SavesOnInterrupt>();
}

std::vector<measure::Measured> StudyClock::sweep(const std::vector<std::string>& names,
                                                 double seconds, std::uint64_t seed,
                                                 std::uint32_t most_samples,
                                                 const std::function<bool(std::size_t)>& always,
                                                 const measure::Render& render) {
  const double after = left() - seconds;
  measure::SweepOptions o = options(seconds, seed);
  o.most_samples = most_samples;
  o.always = always;
  o.progress = [&](const std::string& next, double rest) { announce(next, rest + after); };
  return measure::sweep(names, o, render);
}

void StudyClock::require_whole() {
  if (interrupted()) throw Error("interrupted; the report contains the measurements so far");
}

void StudyClock::stop() { report_.used = clock_seconds() - begin_; }

}  // namespace pvol::cli
