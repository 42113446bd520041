#include "pvol/measure/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "pvol/error.h"
#include "pvol/measure/trade.h"

namespace pvol::measure {
namespace {

/// Fewest rounds, the counted one included, and samples a pixel that give a figure with an error.
constexpr int kFewestRounds = 4;
constexpr std::uint32_t kFewestSamples = 2;

/// Part of the time left that all pilots may take together: then no other begins. Making bounds
/// cannot be stopped, so that the last one may take longer.
constexpr double kPilotsShare = 0.35;

/// Part of its share that a pilot may take at most; of all the time left for the first one.
constexpr double kPilotShare = 0.25;

/// How many times as long as its pilot foretold a render may take: the machine may be busy. What
/// takes less than a part of all the time left may take that long: a short render is held up by
/// anything.
constexpr double kPatience = 4, kLittle = 0.05;

std::string text_of_seconds(double seconds) {
  char text[32];
  const bool brief = seconds < 0.9995;
  std::snprintf(text, sizeof text,
                brief            ? "%.0f ms"
                : seconds < 99.5 ? "%.1f s"
                                 : "%.0f s",
                brief ? 1000 * seconds : seconds);
  return text;
}

/// The same sums everywhere.
bool same_pixels(const Film& a, const Film& b) {
  return std::equal(a.pixels.begin(), a.pixels.end(), b.pixels.begin(), b.pixels.end(),
                    [](const PixelSums& p, const PixelSums& q) {
                      return p.samples == q.samples && p.sum == q.sum &&
                             p.sum_squares == q.sum_squares && p.alpha == q.alpha;
                    });
}

bool same_work(const Run& a, const Run& b) {
  const auto bytes = [](const SetUp& s) {
    return std::array{s.field_bytes, s.octree_bytes, s.micro_bytes};
  };
  return a.complete && b.complete && a.counts == b.counts && bytes(a.set_up) == bytes(b.set_up) &&
         same_pixels(a.film, b.film);
}

double samples_in(const Film& film) {
  double n = 0;
  for (const PixelSums& p : film.pixels) n += p.samples;
  return n;
}

/// Renders in turn and keeps the clock.
class Sweep {
 public:
  Sweep(const std::vector<std::string>& names, const SweepOptions& options, const Render& render)
      : names_(names), o_(options), render_(render), results_(names.size()), plans_(names.size()) {
    end_ = o_.clock() + o_.budget;
  }

  std::vector<Measured> measure() {
    plan();
    int most = 0;
    for (const Plan& p : plans_) most = std::max(most, p.rounds);
    for (int round = 0; round < most; ++round) take_round(round, most);
    for (std::size_t i = 0; i < results_.size(); ++i) check(i);
    return std::move(results_);
  }

 private:
  [[nodiscard]] double left() const { return end_ - o_.clock(); }
  [[nodiscard]] bool cut() const { return o_.interrupted && o_.interrupted(); }

  void tell(const std::string& next) const {
    if (o_.progress) o_.progress(next, std::max(0.0, left()));
  }

  void plan() {
    std::vector<PilotCost> costs(names_.size());
    const double pilots_end = o_.clock() + kPilotsShare * left();
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (cut()) {
        check(i);
      } else if (i == 0 || o_.clock() < pilots_end) {
        costs[i] = pilot(i);
      } else {
        leave_out(i, "the budget leaves no time for its pilot render");
      }
    }
    const double first = plan_first(costs[0]);
    // What settings that are left out would take goes to the others.
    const auto share = [&] {
      const auto open = std::count_if(results_.begin() + 1, results_.end(),
                                      [](const Measured& m) { return m.left_out.empty(); });
      return (left() - first) / double(open);
    };
    // The dearest leaves first: what it would take may be enough for all others.
    std::vector<std::size_t> order;
    for (std::size_t i = 1; i < names_.size(); ++i) {
      if (results_[i].left_out.empty()) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return least(costs[a]) > least(costs[b]);
    });
    for (const std::size_t i : order) {
      if (plan_rounds(costs[i], share(), o_).rounds > 0) break;
      too_slow(i, costs[i]);
    }
    for (std::size_t i = 1; i < names_.size(); ++i) {
      if (results_[i].left_out.empty()) plans_[i] = plan_rounds(costs[i], share(), o_);
      results_[i].samples = plans_[i].samples;
    }
  }

  /// The first setting stands in every ratio: it gets more than its share where it would not take
  /// all rounds. Returns what it gets.
  double plan_first(const PilotCost& cost) {
    constexpr double kMostForAllRounds = 0.2, kMost = 0.5;  // of the time left
    double share = left() / double(names_.size());
    const auto enough = [&] {
      plans_[0] = plan_rounds(cost, share, o_);
      return plans_[0].rounds == o_.rounds ||
             (plans_[0].rounds > 0 && share > kMostForAllRounds * left());
    };
    for (; !enough(); share *= 1.25) {
      if (share > kMost * left()) too_slow(0, cost);
    }
    results_[0].samples = plans_[0].samples;
    return share;
  }

  PilotCost pilot(std::size_t i) {
    tell("pilot render of " + names_[i]);
    RunRequest request{.setting = i, .seed = o_.seed, .count = true, .pilot = true};
    // Without the first setting there is nothing to compare: a busy machine must not stop its
    // pilot.
    request.most_seconds = kPilotShare * left() / (i == 0 ? 1 : double(names_.size() - i));
    const double begin = o_.clock();
    try {
      Run run = render_(request);
      const double seconds = o_.clock() - begin;
      const double n = samples_in(run.film);
      if (n == 0 && cut()) {
        check(i);
        return {};
      }
      if (n == 0) {
        const std::string why =
            "one sample of each pixel takes more than " + text_of_seconds(request.most_seconds);
        if (i == 0)
          throw Error("the budget is too short: for " + names_[0] + ' ' + why + "; " + o_.remedy);
        leave_out(i, why);
        return {};
      }
      const double own = run.seconds + run.set_up.seconds;
      const double samples_share = own > 0 ? run.seconds / own : 0;
      results_[i].set_up = run.set_up;
      if (i == 0) {
        first_ = std::move(run);
      } else if (o_.always && !o_.always(i) && same_work(run, first_)) {
        leave_out(i, "does the same as " + names_[0]);
      }
      return {seconds * (1 - samples_share), seconds * samples_share / n};
    } catch (const Error& e) {
      if (i == 0) throw;
      leave_out(i, e.what());
      return {};
    }
  }

  /// Seconds that a setting takes to be measured at all.
  [[nodiscard]] double least(const PilotCost& cost) const {
    return kFewestRounds * (cost.set_up + kFewestSamples * cost.sample * double(o_.pixels));
  }

  void too_slow(std::size_t i, const PilotCost& cost) {
    const std::string needs = "needs about " + text_of_seconds(least(cost));
    if (i == 0) {
      throw Error("the budget is too short: " + names_[0] + " alone " + needs + ", and " +
                  text_of_seconds(std::max(0.0, left())) + " are left after the pilot renders; " +
                  o_.remedy);
    }
    leave_out(i, needs + ", which exceeds its share of the budget");
  }

  void leave_out(std::size_t i, const std::string& why) { results_[i].left_out = why; }

  /// Seconds that a round of a setting should take.
  [[nodiscard]] double expected(std::size_t i) const {
    return plans_[i].seconds / plans_[i].rounds;
  }

  /// Seconds after which a round of it is stopped.
  [[nodiscard]] double longest(std::size_t i) const {
    return std::min(left(), std::max(kPatience * expected(i), kLittle * left()));
  }

  void take_round(int round, int most) {
    // Another one begins each time, so that none has always the same one before it.
    const std::size_t n = names_.size();
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = (k + std::size_t(round)) % n;
      if (round >= plans_[i].rounds) continue;
      if (left() < expected(i)) continue;
      if (cut()) return;
      tell("round " + std::to_string(round + 1) + " of " + std::to_string(most) + ": " + names_[i]);
      take(i, round);
    }
  }

  void take(std::size_t i, int round) {
    Measured& m = results_[i];
    const RunRequest request{.setting = i,
                             .samples = m.samples,
                             .seed = o_.seed + 1 + std::uint64_t(round) * names_.size() + i,
                             .count = m.counted == 0,  // in the first that is complete
                             .most_seconds = longest(i)};
    const Run run = render_(request);
    if (!run.complete) {
      // It would take the others' time again in every round.
      if (i > 0) plans_[i].rounds = 0;
      return;
    }
    if (m.film.pixels.empty()) {
      m.film = run.film;
    } else {
      add_samples(m.film, run.film);
    }
    const double n = samples_in(run.film);
    if (request.count) {
      m.counts = run.counts;
      m.counted = std::uint64_t(n);
      m.counted_film = run.film;
      return;
    }
    m.set_up = run.set_up;
    m.round.push_back(round);
    m.set_up_seconds.push_back(run.set_up.seconds);
    m.seconds.push_back(run.seconds / n);
    m.variance.push_back(sample_variance(run.film));
    if (run.instructions) m.instructions.push_back(double(*run.instructions) / n);
  }

  void check(std::size_t i) {
    const Measured& m = results_[i];
    const int enough = cut() ? 1 : kFewestRounds - 1;
    if (!m.left_out.empty() || (m.rounds() >= enough && m.counted > 0)) return;
    const std::string why = cut() ? "interrupted before it was measured"
                            : plans_[i].rounds == 0
                                ? "took far longer than its pilot render predicted"
                                : "the budget ran out before it was measured";
    if (i == 0) throw Error(names_[0] + ": " + why);
    leave_out(i, why);
  }

  const std::vector<std::string>& names_;
  const SweepOptions& o_;
  const Render& render_;
  std::vector<Measured> results_;
  std::vector<Plan> plans_;
  Run first_;  // the first setting's pilot
  double end_ = 0;
};

}  // namespace

Plan plan_rounds(const PilotCost& cost, double share, const SweepOptions& o) {
  // Pilots of small pictures run with cold caches and tell the cost to a few ten per cent.
  constexpr double kReserve = 0.85;
  const double picture = cost.sample * double(o.pixels);
  const auto samples_in = [&](int rounds) {
    return (kReserve * share / rounds - cost.set_up) / picture;
  };
  Plan p;
  for (p.rounds = o.rounds; p.rounds > 0 && samples_in(p.rounds) < kFewestSamples;) --p.rounds;
  if (p.rounds < kFewestRounds) return {};
  p.samples = std::uint32_t(std::min(std::floor(samples_in(p.rounds)), double(o.most_samples)));
  p.seconds = p.rounds * (cost.set_up + picture * p.samples);
  return p;
}

std::vector<Measured> sweep(const std::vector<std::string>& names, const SweepOptions& options,
                            const Render& render) {
  return Sweep(names, options, render).measure();
}

Film render_reference(const SweepOptions& o, const Render& render) {
  const double end = o.clock() + o.budget;
  RunRequest request{.samples = 2, .seed = o.seed, .most_seconds = o.budget};
  Film sum;
  for (;;) {
    const double begin = o.clock();
    const Run run = render(request);
    if (!run.complete && o.interrupted && o.interrupted()) {
      if (sum.pixels.empty()) throw Error("interrupted before anything was measured");
      return sum;
    }
    if (!run.complete) {
      throw Error("the budget is too short: two samples a pixel for the reference take more than " +
                  text_of_seconds(std::max(0.0, o.budget)) + "; " + o.remedy);
    }
    if (sum.pixels.empty()) {
      sum = run.film;
    } else {
      add_samples(sum, run.film);
    }
    // Growing chunks, so that setting up takes little of the time whatever a sample costs.
    const double took = o.clock() - begin, left = end - o.clock();
    const double grown = std::min(4.0, 0.8 * left / took) * request.samples;
    if (grown < 1 || left < 0.1 * o.budget || (o.interrupted && o.interrupted())) return sum;
    request.samples = std::uint32_t(std::min(grown, double(o.most_samples)));
    ++request.seed;
    request.most_seconds = std::numeric_limits<double>::infinity();
  }
}

}  // namespace pvol::measure
