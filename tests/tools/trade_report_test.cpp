// The judgement of pvol-stats trade: biased settings are caught, others are not, and the advice can
// be typed.
#include "stats/trade_report.h"

#include <gtest/gtest.h>

#include <fstream>

#include "stats/trade_variants.h"
#include "support/effort.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol::cli {
namespace trade_report_test {

/// A ball of 40 voxels, 30 mean free paths thick, at 32 x 24 pixels.
struct ThickBall {
  testing::ScratchFolder folder;
  LoadedScene loaded;

  ThickBall() {
    const std::string recipe = folder / "ball.toml";
    std::ofstream(recipe) << "[recipe]\nresolution = 40\nedge = 0.05\n[[form]]\n"
                             "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = [1, 1, 1]\n";
    SceneOptions o;
    o.input = recipe;
    o.thickness = 30;
    o.size = {32, 24};
    loaded = load_scene(o, 1, true);
  }

  static double work(const Counts& c) {
    return double(c.path.segments + c.shadow.segments + c.collisions + c.path.null_collisions +
                  c.path.lookups + c.shadow.lookups);
  }

  /// The setting measured with a fixed number of samples in a few rounds.
  [[nodiscard]] measure::Measured measure(const Candidate& v, std::uint64_t seed) const {
    measure::Measured m;
    m.samples = 16;
    for (std::uint64_t round = 0; round < 3; ++round) {
      const measure::RunRequest request{
          .samples = m.samples, .seed = seed + round, .count = true, .most_seconds = 1e9};
      const measure::Run run = render_changed(loaded, v.scene, v.cloud, request, 1);
      const double n = double(run.film.pixels.size()) * m.samples;
      if (round == 0) {
        m.film = m.counted_film = run.film;
        m.counts = run.counts;
        m.counted = std::uint64_t(n);
        continue;
      }
      add_samples(m.film, run.film);
      m.set_up = run.set_up;
      // Work in place of time, which depends on what else the machine does.
      m.round.push_back(int(round));
      m.set_up_seconds.push_back(0.01);
      m.seconds.push_back(1e-7 * work(run.counts) / n);
      m.variance.push_back(measure::sample_variance(run.film));
    }
    return m;
  }

  [[nodiscard]] StudyReport judged(const std::vector<Candidate>& candidates) const {
    StudyReport report;
    report.name = "my cloud.vdb";
    report.loaded = loaded;
    measure::Study& study = report.study;
    study.goals = {{.error = 0.05}, {.seconds = 10}};
    study.picture_pixels = double(loaded.picture_width) * loaded.picture_height;
    const measure::RunRequest many{.samples = 128, .seed = 1u << 20, .most_seconds = 1e9};
    measure::set_reference(study, render_changed(loaded, {}, {}, many, 2).film);
    std::vector<measure::Variant> variants;
    std::vector<measure::Measured> measured;
    std::size_t number = 0;
    for (const Candidate& c : candidates) {
      ++number;  // on a commit every other one, of those without bias
      if (number > 1 && !c.variant.biased && !proof::has_turn(number)) continue;
      variants.push_back(c.variant);
      measured.push_back(measure(c, 137 * number));
    }
    study.rows = measure::make_rows(variants, std::move(measured));
    measure::judge(study);
    return report;
  }
};

TEST(Trade, CatchesABounceLimitAndNoUnbiasedSetting) {
  const ThickBall ball;
  std::vector<Candidate> candidates{default_candidate()};
  for (const Candidate& c : single_candidates(ball.loaded)) {
    if (!c.variant.biased) candidates.push_back(c);
  }
  candidates.push_back({.variant = {"bounce limit", "--max-bounces 2", true},
                        .scene = [](Scene& s) { s.options.max_bounces = 2; }});
  // 1 % over the whole report, at fixed seeds.
  const StudyReport report = ball.judged(candidates);
  const measure::Study& study = report.study;
  for (const measure::Row& row : study.rows) {
    EXPECT_EQ(row.detected(), row.variant.biased) << label(row.variant);
    EXPECT_EQ(verdict_text(row).find("BIASED") == 0, row.variant.biased);
    EXPECT_EQ(row.offset() > 0, row.variant.biased);
  }
  const measure::Row& limited = study.rows.back();
  EXPECT_LT(limited.bias.luminance.bias, 0);
  EXPECT_GE(limited.offset(), -limited.bias.luminance.relative_bias);
  EXPECT_TRUE(says(verdict_text(limited), "trade.biased_mean_minus"));
  EXPECT_TRUE(limited.on_front);  // much faster: nothing beats it in time

  ASSERT_TRUE(study.goals[0].advice);
  EXPECT_FALSE(study.rows[study.goals[0].advice->setting].variant.biased);
  EXPECT_LE(study.goals[0].advice->error, 0.05);
  EXPECT_EQ(command_line(report, *study.goals[0].advice).find("pvol-render 'my cloud.vdb' "), 0u);
}

TEST(Trade, TriesLampsAlongFlightsWhereThereAreLamps) {
  ThickBall ball;
  const auto tries = [&] {
    return std::ranges::any_of(single_candidates(ball.loaded), [](const Candidate& c) {
      return c.variant.option == "--line-lamps on";
    });
  };
  ball.loaded.file.scene.lights = {Sun{}};
  EXPECT_FALSE(tries());
  ball.loaded.file.scene.lights.push_back(PointLight{});
  EXPECT_TRUE(tries());
}

TEST(Trade, ComparesTheDefaultWithItself) {
  const ThickBall ball;
  const measure::Study study = ball.judged({default_candidate()}).study;
  EXPECT_EQ(study.rows[0].time.value, 1);
  EXPECT_EQ(study.rows[0].cost.low, 1);
  EXPECT_EQ(study.rows[0].cost.high, 1);
  EXPECT_TRUE(study.rows[0].on_front);
  EXPECT_EQ(label(study.rows[0].variant), "default");
}

// --- combinations -------------------------------------------------------------------------------

std::vector<Candidate> three_factors() {
  const auto limit = [](std::uint32_t n) { return [n](Scene& s) { s.options.max_bounces = n; }; };
  return {{.variant = {"a", "--a1"}, .scene = [](Scene& s) { s.options.depth = 1; }},
          {.variant = {"a", "--a2"}, .scene = [](Scene& s) { s.options.depth = 2; }},
          {.variant = {"b", "--b1"}, .scene = [](Scene& s) { s.options.seed = 7; }},
          {.variant = {"c", "--c1"}},
          {.variant = {"d", "--d1", true}, .scene = limit(3)},
          {.variant = {"e", "--e1", true}, .scene = limit(4)}};
}

TEST(Combinations, JoinTheBestOfEachFactorThatGains) {
  const std::vector<Candidate> singles = three_factors();
  const std::vector<measure::VariantResult> results{
      {true, 0.9, 0.95},      {true, 0.7, 0.8},
      {true, 0.8, 0.9},       {true, 0.5, 1.1},  // not proven
      {true, 0.3, 0.4, 0.01}, {true, 0.2, 0.3, 0.5}};
  const std::vector<Candidate> found = combinations(singles, results);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].variant.option, "--a2 --b1");
  EXPECT_FALSE(found[0].variant.biased);
  EXPECT_EQ(found[1].variant.option, "--d1 --a2");  // e is too far off
  EXPECT_TRUE(found[1].variant.biased);
  Scene scene;
  found[0].scene(scene);
  EXPECT_EQ(scene.options.depth, 2);
  EXPECT_EQ(scene.options.seed, 7u);
}

TEST(Combinations, AreNoneWhereNothingGains) {
  EXPECT_TRUE(combinations(three_factors(), std::vector<measure::VariantResult>(6)).empty());
}

}  // namespace trade_report_test
}  // namespace pvol::cli
