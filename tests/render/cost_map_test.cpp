// Where the work of a picture is said to be: that sums are right, and that it is where paths do it.
#include "pvol/render/cost_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "pvol/math/rng.h"
#include "support/small_cloud.h"

namespace pvol {
namespace cost_map_test {

using test::cloud;
using test::cloud_scene;
using test::CloudScene;

struct Mapped {
  Volume volume;
  RenderPlan plan;
  explicit Mapped(const CloudScene& s)
      : volume(make_volume(cloud().grid, build_pyramid(cloud().grid), s)),
        plan(pvol::plan(std::span(&volume, 1), s.scene())) {}
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
};

CloudScene large_scene() {
  CloudScene s = cloud_scene();
  s.options.width = 120, s.options.height = 90;
  return s;
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

TEST(CostMap, SumsUpToTheSamples) {
  const Mapped m(large_scene());
  const CostMap map = map_cost(m.plan, 400);
  EXPECT_NEAR(map.columns * map.rows, 400, 60);
  EXPECT_NEAR(sum(map.work), m.plan.forecast.samples, 1e-9 * m.plan.forecast.samples);
  EXPECT_TRUE(map.pilot_work.empty());
  EXPECT_NEAR(CostSums(map, map.work).of({0, 0, 120, 90}), sum(map.work), 1e-12 * sum(map.work));
}

TEST(CostMap, IsTheSameAtEachCallAndForAnyNumberOfThreads) {
  CloudScene s = large_scene();
  const CostMap two = map_cost(Mapped(s).plan, 400);
  s.options.threads = 1;
  EXPECT_EQ(two.work, map_cost(Mapped(s).plan, 400).work);
}

TEST(CostMap, FollowsWhatARenderCounts) {
  CloudScene s = large_scene();
  s.options.aovs.add(Aov::collisions);
  s.options.samples = 16;
  s.options.kernel = KernelKind::scalar;
  const Mapped m(s);
  const CostMap map = map_cost(m.plan, 400);
  const CostSums cost(map, map.work);
  const Film film = render(m.plan).film;
  const auto work = [&](const PixelRect& r) {  // in nanoseconds of the cost model
    double sum = 0;
    for (int y = r.y; y < r.y + r.height; ++y) {
      for (int x = r.x; x < r.x + r.width; ++x) {
        const std::size_t i = film.index(x, y);
        sum += 200 * film.pixels[i].samples +
               150 * double(film.count(i, PixelCounter::collisions)) +
               45 * double(film.count(i, PixelCounter::segments)) +
               40 * double(film.count(i, PixelCounter::lookups));
      }
    }
    return sum;
  };
  const PixelRect corner{0, 0, 20, 20}, middle{40, 30, 40, 30}, all{0, 0, 120, 90};
  EXPECT_LT(cost.of(corner), 0.1 * 400 / 1200 * cost.of(middle)) << "the sky is cheap";
  EXPECT_NEAR(cost.of(middle) / cost.of(all), work(middle) / work(all), 0.03);
}

TEST(CostMap, CoversACrop) {
  CloudScene s = large_scene();
  s.options.crop_x = 31, s.options.crop_y = 17, s.options.crop_width = 47,
  s.options.crop_height = 40;
  const Mapped m(s);
  const CostMap map = map_cost(m.plan, 100);
  EXPECT_LE(map.left, 31);
  EXPECT_LE(map.top, 17);
  EXPECT_GE(map.left + map.columns * map.cell_width, 78 - 1e-9);
  EXPECT_GE(map.top + map.rows * map.cell_height, 57 - 1e-9);
  EXPECT_EQ(rendered_part(s.options), (PixelRect{31, 17, 47, 40}));
}

TEST(CostMap, CoversACropByCellsThatAreNotSquare) {
  CloudScene s = large_scene();
  s.options.crop_x = 70, s.options.crop_y = 50;
  s.options.crop_width = 50, s.options.crop_height = 40;
  const CostMap map = map_cost(Mapped(s).plan, 1);
  EXPECT_EQ(map.cell_width, 40);
  EXPECT_EQ(map.cell_height, 45);
  EXPECT_EQ(map.left, 40);
  EXPECT_EQ(map.top, 45);
  EXPECT_EQ(map.columns * map.rows, 2);
}

TEST(CostMap, OfATinyPictureHasACellForEachPixel) {
  const Mapped m(cloud_scene());
  const CostMap map = map_cost(m.plan, 10'000);
  EXPECT_EQ(map.columns, 12);
  EXPECT_EQ(map.rows, 12);
  EXPECT_EQ(map.cell_width, 1);
}

TEST(CostMap, OfAPictureAdaptiveTellsThePilotApart) {
  CloudScene s = large_scene();
  s.options.noise = 0.01;
  const Mapped m(s);
  const CostMap map = map_cost(m.plan, 400);
  ASSERT_EQ(map.pilot_work.size(), map.work.size());
  for (std::size_t i = 0; i < map.work.size(); ++i) {
    EXPECT_GE(map.work[i], map.pilot_work[i]);
  }
  EXPECT_GT(sum(map.work), 2 * sum(map.pilot_work));
  s.options.noise = 0.02;
  const double less = sum(map_cost(Mapped(s).plan, 400).work);
  EXPECT_NEAR(sum(map.work) / less, 4, 0.6) << "a quarter of the samples for twice the noise";
}

TEST(CostSums, AreThoseOfEvenCells) {
  CostMap map;
  map.left = -1, map.top = 2, map.cell_width = 2.5, map.cell_height = 1.5;
  map.columns = 5, map.rows = 4;
  Rng rng(1, 2, 3);
  for (int i = 0; i < 20; ++i) map.work.push_back(double(rng.uniform()));
  const CostSums sums(map, map.work);
  const auto by_hand = [&](const PixelRect& r) {
    double total = 0;
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 5; ++i) {
        const double x = map.left + i * 2.5, y = map.top + j * 1.5;
        const double w = std::min(x + 2.5, double(r.x + r.width)) - std::max(x, double(r.x));
        const double h = std::min(y + 1.5, double(r.y + r.height)) - std::max(y, double(r.y));
        if (w > 0 && h > 0) total += map.work[std::size_t(5 * j + i)] * w * h / 3.75;
      }
    }
    return total;
  };
  for (const PixelRect& r : {PixelRect{0, 2, 1, 1}, {1, 3, 5, 4}, {-3, 0, 30, 30}, {4, 4, 3, 2}}) {
    EXPECT_NEAR(sums.of(r), by_hand(r), 1e-12);
  }
}

}  // namespace cost_map_test
}  // namespace pvol
