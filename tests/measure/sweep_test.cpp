// Measuring in turn within a budget, with a clock that counts the work instead of the time.
#include "pvol/measure/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "pvol/error.h"
#include "pvol/math/rng.h"
#include "support/messages.h"

namespace pvol::measure {
namespace sweep_test {

/// What a setting of the test costs, in seconds of the counted clock.
struct FakeSetting {
  double set_up = 0, sample = 1e-3;
  double deviation = 1;   // of a sample
  double surprise = 1;    // factor by which samples cost more than in the pilot
  std::string refusal{};  // thrown instead
};

/// Renders noise, and lets a clock run by what that costs.
struct FakeRenderer {
  std::vector<FakeSetting> settings;
  double now = 100;
  std::vector<RunRequest> requests{};

  static constexpr int kPixels = 64;

  Run operator()(const RunRequest& r) {
    const FakeSetting& s = settings[r.setting];
    if (!s.refusal.empty()) throw Error(s.refusal);
    requests.push_back(r);
    const double start = now, cost = s.sample * (r.pilot ? 1 : s.surprise);
    now += s.set_up;
    Run run;
    run.set_up.seconds = s.set_up;
    run.film.width = run.film.crop_width = r.pilot ? kPixels / 16 : kPixels;
    run.film.height = run.film.crop_height = 1;
    run.film.pixels.resize(std::size_t(run.film.crop_width));
    for (std::size_t p = 0; p < run.film.pixels.size(); ++p) {
      Rng rng(r.seed, p, 0);
      for (std::uint32_t k = 0; k < r.samples && run.complete; ++k) {
        const Vec3d v(10 + s.deviation * (double(rng.uniform()) - 0.5));
        run.film.pixels[p].sum += v;
        run.film.pixels[p].sum_squares += v * v;
        ++run.film.pixels[p].samples;
        now += cost, run.seconds += cost;
        run.complete = now - start <= r.most_seconds;
      }
    }
    return run;
  }
};

SweepOptions options_for(const FakeRenderer& renderer, double budget) {
  SweepOptions o;
  o.budget = budget;
  o.pixels = FakeRenderer::kPixels;
  o.clock = [&renderer] { return renderer.now; };
  return o;
}

std::vector<Measured> run_sweep(FakeRenderer& renderer, double budget) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < renderer.settings.size(); ++i) {
    names.push_back("setting " + std::to_string(i));
  }
  return sweep(names, options_for(renderer, budget), std::ref(renderer));
}

TEST(Sweep, KeepsItsBudgetAndUsesMostOfIt) {
  for (const double budget : {30.0, 100.0, 2000.0}) {
    FakeRenderer renderer{{{0.1, 1e-3}, {0.01, 4e-3}, {0.3, 1e-3}, {0, 1e-4}}};
    const std::vector<Measured> m = run_sweep(renderer, budget);
    EXPECT_LE(renderer.now - 100, budget);
    EXPECT_GE(renderer.now - 100, 0.7 * budget);
    for (const Measured& s : m) EXPECT_EQ(s.left_out, "");
  }
}

TEST(Sweep, MeasuresCostAndVarianceOfEachInEveryRound) {
  FakeRenderer renderer{{{0, 1e-3, 1}, {0.2, 3e-3, 2}}};
  const std::vector<Measured> m = run_sweep(renderer, 200);
  ASSERT_EQ(m.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(m[i].rounds(), 6);  // and one that counts
    for (const double s : m[i].seconds) EXPECT_NEAR(s, i == 0 ? 1e-3 : 3e-3, 1e-9);
    for (const double v : m[i].variance)
      EXPECT_NEAR(v, (i == 0 ? 1.0 : 4.0) / 12, 0.05 * double(i + 1));
    EXPECT_EQ(m[i].counted, std::uint64_t(m[i].samples) * FakeRenderer::kPixels);
    EXPECT_EQ(m[i].film.pixels[0].samples, 7 * m[i].samples);
  }
  EXPECT_GT(m[0].samples, 2 * m[1].samples);  // the same time for both
}

TEST(Sweep, TakesTurnsAndAnotherSeedEachTime) {
  FakeRenderer renderer{{{}, {}, {}}};
  (void)run_sweep(renderer, 60);
  std::set<std::uint64_t> seeds;
  std::vector<std::size_t> order;
  for (const RunRequest& r : renderer.requests) {
    if (r.pilot) continue;
    EXPECT_TRUE(seeds.insert(r.seed).second);
    order.push_back(r.setting);
  }
  ASSERT_EQ(order.size(), 21u);
  for (std::size_t round = 0; round < 7; ++round) {
    std::set<std::size_t> in_round(order.begin() + std::ptrdiff_t(3 * round),
                                   order.begin() + std::ptrdiff_t(3 * round + 3));
    EXPECT_EQ(in_round.size(), 3u);
    EXPECT_EQ(order[3 * round], round % 3);  // another one is first each time
  }
}

TEST(Sweep, LeavesOutWhatDoesNotFitAndSaysWhy) {
  FakeRenderer renderer{{{0, 1e-3}, {0, 10}, {0, 1e-3, 1, 1, "the scene does not allow it"}}};
  const std::vector<Measured> m = run_sweep(renderer, 60);
  EXPECT_EQ(m[0].left_out, "");
  EXPECT_NE(m[1].left_out, "");
  EXPECT_EQ(m[2].left_out, "the scene does not allow it");
  EXPECT_LE(renderer.now - 100, 60 * 1.2);  // one sample of 10 s cannot be interrupted
}

TEST(Sweep, StartsNoPilotsOnceTheyHaveTakenTheirPart) {
  // Making bounds takes 3 s, which no limit on samples shortens.
  FakeRenderer renderer{{{0, 1e-3}, {3, 1e-3}, {3, 1e-3}, {3, 1e-3}, {3, 1e-3}, {3, 1e-3}}};
  const std::vector<Measured> m = run_sweep(renderer, 20);
  EXPECT_EQ(m[0].left_out, "");
  EXPECT_TRUE(says(m[5].left_out, "trade.budget_leaves_no_time"));
  EXPECT_LE(renderer.now - 100, 20.1);
}

TEST(Sweep, StopsWhatCostsMoreThanItsPilotSaid) {
  FakeRenderer renderer{{{0, 1e-3}, {0, 1e-3, 1, 50}}};
  const std::vector<Measured> m = run_sweep(renderer, 20);
  EXPECT_LE(renderer.now - 100, 20.1);
  EXPECT_NE(m[1].left_out, "");
}

TEST(Sweep, KeepsItsBudgetWhereTheMachineSlowsDown) {
  FakeRenderer renderer{{{0.1, 1e-3, 1, 2}, {0.1, 2e-3, 1, 2}, {0, 1e-3, 1, 2}}};
  const std::vector<Measured> m = run_sweep(renderer, 50);
  EXPECT_LE(renderer.now - 100, 50.1);
  for (const Measured& s : m) {
    EXPECT_EQ(s.left_out, "");
    EXPECT_LT(s.rounds(), 6);
    EXPECT_GE(s.rounds(), 3);
  }
}

TEST(Sweep, NeedsItsFirstSetting) {
  FakeRenderer slow{{{0, 1}, {0, 1e-3}}};
  EXPECT_THROW((void)run_sweep(slow, 20), Error);
  FakeRenderer refused{{{0, 1e-3, 1, 1, "no"}, {0, 1e-3}}};
  EXPECT_THROW((void)run_sweep(refused, 20), Error);
  const FakeRenderer clock{{}};
  const auto stopped_before_a_sample = [](const RunRequest&) {
    measure::Run run;
    run.complete = false;
    run.film.pixels.resize(1);
    return run;
  };
  EXPECT_THROW((void)sweep({"one"}, options_for(clock, 20), stopped_before_a_sample), Error);
}

TEST(Sweep, GivesTheFirstSettingMoreThanItsShareWhereItNeedsIt) {
  FakeRenderer renderer{{{0, 0.02}, {}, {}, {}, {}, {}, {}, {}}};  // 18 s for 7 x 2 samples
  const std::vector<Measured> m = run_sweep(renderer, 70);
  EXPECT_GE(m[0].rounds(), 3);
  EXPECT_GE(m[7].rounds(), 3);
  EXPECT_LE(renderer.now - 100, 70);
}

TEST(Sweep, LetsABusyMachineFinishTheFirstPilotHoweverManySettingsThereAre) {
  FakeRenderer renderer{std::vector<FakeSetting>(10)};
  // A stall of a second: more than a tenth of what pilots may take, and less than all of it.
  const auto stalled = [&](const RunRequest& r) {
    if (!r.pilot || r.setting > 0 || r.most_seconds > 1) return renderer(r);
    measure::Run run;
    run.complete = false;
    run.film.pixels.resize(1);
    return run;
  };
  const std::vector<std::string> names(10, "a setting");
  for (const Measured& m : sweep(names, options_for(renderer, 20), stalled)) {
    EXPECT_EQ(m.left_out, "");
  }
}

TEST(Sweep, LetsStallsPassThatAreShortBesideItsBudget) {
  FakeRenderer renderer{std::vector<FakeSetting>(10)};
  // Of a second, in each render of a tenth of one.
  const auto stalled = [&](const RunRequest& r) {
    if (r.pilot) return renderer(r);
    renderer.now += 1;
    if (r.most_seconds > 1) return renderer(r);
    measure::Run run;
    run.complete = false;
    run.film.pixels.resize(1);
    return run;
  };
  SweepOptions o = options_for(renderer, 100);
  o.most_samples = 2;
  for (const Measured& m : sweep(std::vector<std::string>(10, "a setting"), o, stalled)) {
    EXPECT_EQ(m.left_out, "");
  }
}

TEST(Sweep, SaysWhatComesNext) {
  FakeRenderer renderer{{{}, {}}};
  std::vector<std::string> said;
  SweepOptions o = options_for(renderer, 10);
  o.progress = [&](const std::string& next, double left) {
    said.push_back(next);
    EXPECT_GE(left, 0);
    EXPECT_LE(left, 10);
  };
  (void)sweep({"one", "two"}, o, std::ref(renderer));
  ASSERT_GE(said.size(), 4u);
  EXPECT_TRUE(says(said[0], "trade.pilot_render"));
  EXPECT_TRUE(says(said[2], "trade.round"));
}

TEST(Sweep, LeavesOutTheDearestUntilAllOthersFit) {
  // Seven of 2 s do not fit beside one of 9 s, but they do without it.
  std::vector<FakeSetting> settings(8, FakeSetting{0.5, 1e-4});
  settings[1].set_up = 2.2;
  FakeRenderer renderer{settings};
  const std::vector<Measured> m = run_sweep(renderer, 25);
  EXPECT_NE(m[1].left_out, "");
  for (const std::size_t i : {0u, 2u, 3u, 4u, 5u, 6u, 7u}) EXPECT_EQ(m[i].left_out, "") << i;
}

TEST(Sweep, LeavesOutWhatDoesTheSameAsTheFirst) {
  // All of them have the same noise; the third costs more look-ups, the fourth more memory.
  FakeRenderer renderer{std::vector<FakeSetting>(5)};
  const measure::Render render = [&](const RunRequest& r) {
    measure::Run run = renderer(r);
    run.counts.path.lookups = r.setting == 2 ? 20 : 10;
    run.set_up.micro_bytes = r.setting == 3 ? 1 : 0;
    return run;
  };
  const std::vector<std::string> names{"default", "same", "work", "memory", "told"};
  SweepOptions o = options_for(renderer, 60);
  o.always = [](std::size_t i) { return i == 4; };
  const std::vector<Measured> m = sweep(names, o, render);
  EXPECT_TRUE(says(m[1].left_out, "trade.same_default"));
  for (const std::size_t i : {0u, 2u, 3u, 4u}) EXPECT_EQ(m[i].left_out, "") << names[i];
}

TEST(Sweep, KeepsWhatWasMeasuredWhenInterrupted) {
  // In the pilots, in the counted round, within the first timed one; after it and later.
  for (const std::size_t renders : {1u, 4u, 8u, 9u, 13u}) {
    FakeRenderer renderer{std::vector<FakeSetting>(3)};
    SweepOptions o = options_for(renderer, 60);
    o.interrupted = [&] { return renderer.requests.size() >= renders; };
    const std::vector<std::string> names{"a", "b", "c"};
    if (renders < 9) {
      EXPECT_THROW((void)sweep(names, o, std::ref(renderer)), Error);
      continue;
    }
    const std::vector<Measured> m = sweep(names, o, std::ref(renderer));
    for (const Measured& s : m) {
      EXPECT_EQ(s.left_out, "");
      EXPECT_GE(s.rounds(), 1);
      EXPECT_LE(s.rounds(), 3);
    }
  }
}

TEST(Sweep, NamesAStopWithinAPilotAndNotItsCost) {
  // Without a sample of it, as a stop leaves it and a budget that is too short.
  for (const std::size_t stopped : {0u, 1u, 2u}) {
    FakeRenderer renderer{std::vector<FakeSetting>(3)};
    SweepOptions o = options_for(renderer, 60);
    o.interrupted = [&] { return renderer.requests.size() > stopped; };
    const measure::Render render = [&](const RunRequest& r) {
      measure::Run run = renderer(r);
      if (r.setting == stopped) std::ranges::fill(run.film.pixels, PixelSums{});
      return run;
    };
    try {
      (void)sweep({"a", "b", "c"}, o, render);
      ADD_FAILURE() << "nothing was measured";
    } catch (const Error& e) {
      EXPECT_TRUE(says(e.what(), "trade.interrupted_before_measured")) << stopped;
    }
  }
}

TEST(Reference, TakesItsBudgetInGrowingFilmsOfTheFirstSetting) {
  FakeRenderer renderer{{{0.5, 1e-3}, {}}};
  SweepOptions o = options_for(renderer, 100);
  o.seed = 1000;
  const Film film = render_reference(o, std::ref(renderer));
  EXPECT_GE(renderer.now - 100, 90);
  EXPECT_LE(renderer.now - 100, 101);
  std::uint32_t samples = 0;
  for (std::size_t i = 0; i < renderer.requests.size(); ++i) {
    const RunRequest& r = renderer.requests[i];
    EXPECT_EQ(r.setting, 0u);
    EXPECT_EQ(r.seed, 1000 + i);
    samples += r.samples;
  }
  EXPECT_EQ(renderer.requests[1].samples, 4 * renderer.requests[0].samples);
  EXPECT_EQ(film.pixels[0].samples, samples);
}

TEST(Reference, NeedsTimeForTwoSamplesAndEndsWhenInterrupted) {
  FakeRenderer slow{{{0, 1}}};
  EXPECT_THROW((void)render_reference(options_for(slow, 20), std::ref(slow)), Error);
  FakeRenderer renderer{{{}}};
  SweepOptions o = options_for(renderer, 100);
  o.interrupted = [] { return true; };
  EXPECT_EQ(render_reference(o, std::ref(renderer)).pixels[0].samples, 2u);
}

TEST(Plan, GivesFewerSamplesThenFewerRoundsThenNone) {
  SweepOptions o;
  o.pixels = 1000;
  const PilotCost cost{0.1, 1e-4};  // 0.1 s a picture of one sample
  const Plan rich = plan_rounds(cost, 100, o), poor = plan_rounds(cost, 2, o);
  EXPECT_EQ(rich.rounds, o.rounds);
  EXPECT_GT(rich.samples, 50u);
  EXPECT_LE(rich.seconds, 100);
  EXPECT_LT(poor.rounds, o.rounds);
  EXPECT_GE(poor.rounds, 4);
  EXPECT_GE(poor.samples, 2u);
  EXPECT_LE(poor.seconds, 2);
  EXPECT_EQ(plan_rounds(cost, 1, o).rounds, 0);
}

}  // namespace sweep_test
}  // namespace pvol::measure
