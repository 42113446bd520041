// Forecasts of time: which paths are timed, how many, and what follows from them. Clocks are the
// test's own, and work is counted.
#include "render/engine/time_paths.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <atomic>

#include "pvol/render/render.h"
#include "support/kernel.h"
#include "support/small_cloud.h"

namespace pvol {
namespace time_paths_test {

using detail::PathSetup;
using detail::time_paths;
using detail::TimedPaths;
using test::cloud;
using test::cloud_scene;
using test::CloudScene;

CloudScene counting_scene() {
  CloudScene s = cloud_scene();
  s.options.width = 96, s.options.height = 72;
  s.options.count = true, s.options.threads = 2;
  s.options.micro_bounds = MicroBoundsUse::none;  // codes would leave too few look-ups to compare
  return s;
}

struct Planned {
  Volume volume;
  RenderPlan plan;
  explicit Planned(const CloudScene& s)
      : volume(make_volume(cloud().grid, build_pyramid(cloud().grid), s)),
        plan(pvol::plan(std::span(&volume, 1), s.scene(), {.forecast = false})) {}
  Planned(const Planned&) = delete;
  Planned& operator=(const Planned&) = delete;

  /// By plain paths on one thread, whose every tile takes `tick` seconds.
  [[nodiscard]] TimedPaths time(double samples, double tick) const {
    const PathSetup setup(plan);
    tbb::task_arena arena(1);
    std::atomic<int> calls = 0;
    return arena.execute(
        [&] { return time_paths(setup, samples, [&] { return tick * ++calls; }); });
  }
};

/// What a path does on average is what those of the render do.
TEST(TimePaths, FollowsPathsLikeThoseOfTheRender) {
  for (const bool surfaces : {false, true}) {
    CloudScene s = counting_scene();
    s.options.guide = GuideUse::off;
    if (surfaces) s.surfaces = {PlaneSurface{{0, -9, 0}, {0, 1, 0}}};
    const Planned p(s);
    const TimedPaths t = p.time(1e9, 1e-3);
    const RenderResult r = render(p.plan);
    const double samples = 96.0 * 72 * s.options.samples;
    ASSERT_GT(t.paths, 0u);
    for (const Counter& c : kCounters) {
      const double render = double(value(c, r.counts)) / samples;
      const double timed = double(value(c, t.counts)) / double(t.paths);
      EXPECT_NEAR(timed, render, 0.2 * render) << c.name << (surfaces ? ", over a plane" : "");
    }
  }
}

/// Each tile takes a tick: some rows of the small picture, with about 2048 paths.
TEST(TimePaths, TakesAHundredthOfLongRendersAndLittleOfShortOnes) {
  const Planned p(counting_scene());
  EXPECT_NEAR(p.time(1e4, 1.01e-2).seconds, 0.0202, 1e-9);
  const TimedPaths some = p.time(6e5, 1e-2);
  EXPECT_GT(some.seconds, 0.02);
  EXPECT_NEAR(some.seconds, 0.01 * 6e5 * some.seconds_of_path(), 1e-2);
  EXPECT_EQ(p.time(1e3, 10).seconds, 10) << "a tile at least";
  const TimedPaths all = p.time(1e9, 1e-3);
  EXPECT_NEAR(double(all.paths), 512 * 16, 40 * 16) << "the small picture at most";
  EXPECT_NEAR(p.time(1e9, 1.01e-2).cold_seconds, 0.0101, 1e-9);
}

TEST(TimePaths, EndsOnceItIsStopped) {
  const Planned p(counting_scene());
  PathSetup setup(p.plan);
  const std::atomic<bool> stop = true;
  setup.stop = &stop;
  EXPECT_EQ(time_paths(setup, 1e9).paths, 0u);
}

TEST(TimePaths, LeavesTheirBytesToPictures) {
  const Planned p(counting_scene());
  const Film without = render(p.plan).film;
  int calls = 0;
  RenderCallbacks callbacks;
  callbacks.forecast = [&](const TimeForecast& f) {
    ++calls;
    EXPECT_EQ(f.samples, 96.0 * 72 * 64);
    EXPECT_GT(f.sample_seconds, 0);
    EXPECT_EQ(f.threads, 2);
  };
  const RenderResult with = resume(p.plan, {}, callbacks);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(with.counts, render(p.plan).counts);
  for (std::size_t i = 0; i < without.pixels.size(); ++i) {
    ASSERT_EQ(with.film.pixels[i].sum, without.pixels[i].sum);
  }
}

TEST(TimePaths, ForecastsWhatAFilmLacks) {
  CloudScene s = counting_scene();
  const Planned p(s);
  s.options.samples = 16;
  const Planned quarter(s);
  const auto lacking = [&](Film begun) {
    TimeForecast found{.samples = -1};
    RenderCallbacks callbacks;
    callbacks.forecast = [&](const TimeForecast& f) { found = f; };
    (void)resume(p.plan, std::move(begun), callbacks);
    return found;
  };
  EXPECT_EQ(lacking(render(quarter.plan).film).samples, 96.0 * 72 * 48);
  const TimeForecast nothing = lacking(render(p.plan).film);
  EXPECT_EQ(nothing.samples, 0);
  EXPECT_EQ(nothing.own_seconds, 0);
  EXPECT_EQ(forecast_time(p.plan).samples, 96.0 * 72 * 64);
}

}  // namespace time_paths_test
}  // namespace pvol
