// The plan of a render: what it chooses and why, what it expects, and what it refuses.
#include "pvol/render/plan.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pvol/error.h"
#include "pvol/render/render.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/fields.h"

namespace pvol::test {
namespace {

CloudScene scene_around(const Volume& v) {
  CloudScene s;
  s.camera = frame(v.density.world_box, 1);
  s.options.width = s.options.height = 32;
  s.options.samples = 16;
  s.options.count = true;
  s.lights = {Sun{}};
  return s;
}

const Decision& decision(const RenderPlan& p, const std::string& what) {
  const auto found = std::find_if(p.decisions.begin(), p.decisions.end(),
                                  [&](const Decision& d) { return d.what == what; });
  if (found == p.decisions.end()) throw Error("nothing decided about " + what);
  return *found;
}

TEST(Plan, LeavesNothingToChooseAndSaysWhy) {
  const Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  const CloudScene s = scene_around(v);
  const RenderPlan p = plan(std::span(&v, 1), s.scene());
  EXPECT_NE(p.scene.options.transmittance, Transmittance::automatic);
  EXPECT_EQ(p.scene.options.transmittance, p.transmittance.estimator);
  EXPECT_EQ(p.kernel, (Kernel{LookUp::trilinear, 0, Paths::one_volume, true}));
  for (const char* what : {"octree", "micro-bounds", "paths", "shadow rays"}) {
    EXPECT_FALSE(decision(p, what).choice.empty()) << what;
    EXPECT_FALSE(decision(p, what).reason.empty()) << what;
  }
  EXPECT_EQ(p.decisions.size(), 4u) << "a volume without a shell decides nothing about one";
}

TEST(Plan, SaysWhatTheUserTold) {
  Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  v.density.micro = build_micro_bounds(v.density.bricks(), 1);
  CloudScene s = scene_around(v);
  s.options.guide = GuideUse::on;
  s.options.transmittance = Transmittance::ratio;
  s.options.micro_bounds = MicroBoundsUse::cells_1;
  s.options.depth = 1;
  const RenderPlan p = plan(std::span(&v, 1), s.scene());
  for (const Decision& d : p.decisions) EXPECT_EQ(d.reason, "as told") << d.what;
  EXPECT_EQ(decision(p, "shadow rays").choice, "ratio");
  EXPECT_EQ(decision(p, "paths").choice, "guided");
  EXPECT_EQ(p.kernel, (Kernel{LookUp::trilinear, 1, Paths::guided, true}));
}

TEST(Plan, MicroBoundsServeWhereAllVolumesHaveThem) {
  std::vector<Volume> volumes(2, make_test_volume(field("gaussian"), 2, std::nullopt));
  const CloudScene s = scene_around(volumes[0]);
  volumes[0].density.micro = build_micro_bounds(volumes[0].density.bricks(), 2);
  EXPECT_EQ(plan(volumes, s.scene()).kernel.micro_edge, 0);
  volumes[1].density.micro = build_micro_bounds(volumes[1].density.bricks(), 2);
  EXPECT_EQ(plan(volumes, s.scene()).kernel,
            (Kernel{LookUp::trilinear, 2, Paths::many_volumes, true}));
}

TEST(Plan, IsWhatRenderDoes) {
  const Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  const CloudScene s = scene_around(v);
  const Film by_plan = render(plan(std::span(&v, 1), s.scene())).film;
  const Film by_scene = pvol::render(v, s.scene()).film;
  for (std::size_t i = 0; i < by_plan.pixels.size(); ++i) {
    ASSERT_EQ(by_plan.pixels[i].sum, by_scene.pixels[i].sum);
  }
}

/// Thin and thick, few lights and many, with albedo and without.
TEST(Plan, ForecastsCollisionsWithinAFactorOfFour) {
  for (const char* name : {"constant", "gaussian", "exponential", "sparse"}) {
    for (const double depth : {0.2, 1.0, 20.0}) {
      for (const float albedo : {0.0f, 0.5f, 0.999f}) {
        const Field& f = field(name);
        const double extinction = depth / std::max({f.size.x, f.size.y, f.size.z});
        Volume v = make_test_volume(f, extinction, std::nullopt, Tracker::decomposition);
        v.medium.components[0].albedo = Rgb(albedo);
        CloudScene s = scene_around(v);
        s.options.samples = 64;
        const RenderPlan p = plan(std::span(&v, 1), s.scene());
        const double found = double(render(p).counts.collisions);
        EXPECT_EQ(p.forecast.samples, 32 * 32 * 64);
        EXPECT_LT(p.forecast.collisions, 4 * found) << name << ' ' << depth << ' ' << albedo;
        EXPECT_GT(p.forecast.collisions, found / 4) << name << ' ' << depth << ' ' << albedo;
        EXPECT_GT(p.forecast.cpu_seconds, 0);
      }
    }
  }
}

TEST(Plan, ForecastsLessForACropAndABounceLimit) {
  const Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  CloudScene s = scene_around(v);
  const double whole = plan(std::span(&v, 1), s.scene()).forecast.collisions;
  s.options.max_bounces = 0;
  const double first = plan(std::span(&v, 1), s.scene()).forecast.collisions;
  EXPECT_LT(first, whole);
  s.options.crop_x = 16, s.options.crop_width = 16;
  const RenderPlan half = plan(std::span(&v, 1), s.scene());
  EXPECT_EQ(half.forecast.samples, 16 * 32 * 16);
  EXPECT_LT(half.forecast.collisions, first);
}

TEST(Plan, RefusesEndlessWorkByFactsUnlessForced) {
  const Field& f = field("constant");
  Volume v = make_test_volume(f, 1e5, std::nullopt);
  v.medium.components[0].albedo = Rgb(1.0f);
  v.name = "thick.vdb";
  const CloudScene s = scene_around(v);
  const std::vector<VolumeFacts> facts{describe(v, describe(f.grid, 1e5, {}))};
  const auto refusal = [&](const Scene& scene, bool force) -> std::string {
    try {
      (void)plan(std::span(&v, 1), scene, {.facts = facts, .force = force});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(s.scene(), false).find("thick.vdb: a path would scatter about "), 0u);
  EXPECT_EQ(refusal(s.scene(), true), "");
  EXPECT_NO_THROW((void)plan(std::span(&v, 1), s.scene())) << "without facts there is no limit";
  Scene limited = s.scene();
  limited.options.max_bounces = 4;
  EXPECT_EQ(refusal(limited, false), "");
}

}  // namespace
}  // namespace pvol::test
