// The plan of a render: what it chooses and why, what it expects, and what it refuses.
#include "pvol/render/plan.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pvol/error.h"
#include "pvol/render/render.h"
#include "pvol/volume/estimators.h"
#include "render/plan/camera_probe.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace plan_test {

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
  const KernelKind kernel = p.scene.options.kernel;
  EXPECT_NE(kernel, KernelKind::automatic);
  EXPECT_EQ(p.kernel, (Kernel{.kind = kernel, .count = true}));
  EXPECT_TRUE(p.guide.used);
  ASSERT_EQ(p.one_by_one.size(), 1u);
  EXPECT_EQ(p.one_by_one[0], nullptr);
  for (const char* what : {"octree", "micro-bounds", "paths", "kernel", "shadow rays"}) {
    EXPECT_FALSE(decision(p, what).choice.empty()) << what;
    EXPECT_FALSE(decision(p, what).reason.empty()) << what;
  }
  EXPECT_EQ(p.decisions.size(), 5u) << "a volume without a shell decides nothing about one";
}

TEST(Plan, SaysWhatTheUserTold) {
  Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  v.density.micro = build_micro_bounds(v.density.bricks(), 1);
  CloudScene s = scene_around(v);
  s.options.guide = GuideUse::on;
  s.options.transmittance = Transmittance::ratio;
  s.options.micro_bounds = MicroBoundsUse::edge_1;
  s.options.depth = 1;
  s.options.kernel = KernelKind::scalar;
  const RenderPlan p = plan(std::span(&v, 1), s.scene());
  for (const Decision& d : p.decisions) EXPECT_TRUE(says(d.reason, "plan.as_set")) << d.what;
  EXPECT_EQ(decision(p, "shadow rays").choice, "ratio");
  EXPECT_EQ(decision(p, "paths").choice, "guided");
  EXPECT_EQ(p.kernel, (Kernel{.count = true}));
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

/// Volumes of 8 x 12 x 7 cells of density 1, more or less.
Volume make_thick_volume(double extinction, float albedo) {
  Volume v = make_test_volume(field("constant"), extinction, std::nullopt, Tracker::decomposition);
  v.medium.components[0].albedo = Rgb(albedo);
  v.name = "thick.vdb";
  return v;
}

TEST(Plan, RefusesEndlessWorkUnlessForced) {
  const Volume v = make_thick_volume(5e4, 1);
  const CloudScene s = scene_around(v);
  const auto refusal = [&](const Scene& scene, bool force) -> std::string {
    try {
      (void)plan(std::span(&v, 1), scene, {.force = force});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_TRUE(says(refusal(s.scene(), false), "plan.path_scatter_about_times"));
  EXPECT_NE(refusal(s.scene(), false).find("medium.extinction = "), std::string::npos);
  EXPECT_EQ(refusal(s.scene(), true), "");
  Scene limited = s.scene();
  limited.options.max_bounces = 4;
  EXPECT_EQ(refusal(limited, false), "");
}

/// The warnings of a plan, in one string.
std::string warnings(std::span<const Volume> volumes, const CloudScene& s) {
  std::string all;
  for (const std::string& d : plan(volumes, s.scene()).warnings) all += d + '\n';
  return all;
}
std::string warnings(const Volume& v, const CloudScene& s) { return warnings(std::span(&v, 1), s); }
std::string first_of(const std::string& warnings) {
  return warnings.substr(0, warnings.find('\n'));
}

TEST(Plan, DoubtsUnitsByThicknessAndSaysWhatWouldMakeSense) {
  for (const double extinction : {1e-2, 1.0, 100.0}) {
    const Volume v = make_thick_volume(extinction, 0.9f);
    EXPECT_EQ(warnings(v, scene_around(v)), "") << extinction;
  }
  for (const double extinction : {1e-30, 1e-4, 1e4}) {
    const Volume v = make_thick_volume(extinction, 0.9f);
    const std::string text = warnings(v, scene_around(v));
    EXPECT_TRUE(says(first_of(text), "plan.cloud_about_mean"));
    const std::size_t at = text.find("medium.extinction = ");
    ASSERT_NE(at, std::string::npos) << text;
    const Volume proposed = make_thick_volume(std::stod(text.substr(at + 20)), 0.9f);
    const double thickness = choose_transmittance(std::span(&proposed, 1)).thickness;
    EXPECT_GT(thickness, 20) << text;
    EXPECT_LT(thickness, 80) << text;
  }
  const Volume none = make_thick_volume(0, 0.9f);
  const std::string invisible = warnings(none, scene_around(none));
  EXPECT_TRUE(says(invisible, "plan.volume_invisible"));
  EXPECT_EQ(first_of(invisible) + '\n', invisible) << "nothing else";
}

TEST(Plan, DoubtsSunsBehindPlanesAndCamerasInClouds) {
  const Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  CloudScene s = scene_around(v);
  s.surfaces = {PlaneSurface{{0, -40, 0}, {0, -2, 0}, {}}};
  s.lights = {Sun{{1, 1, 0}, Rgb(1.0f), 0}, Sun{{0, 3, 0}, Rgb(1.0f), 0}};
  EXPECT_EQ(warnings(v, s), "") << "whichever side the normal is on";
  s.lights[1] = Sun{{1, -1, 0}, Rgb(1.0f), 0};
  const std::string text = warnings(v, s);
  EXPECT_TRUE(says(first_of(text), "plan.sun_behind_plane"));
  EXPECT_EQ(first_of(text) + '\n', text) << "of one sun alone";
  s.lights.pop_back();
  s.camera.position = v.density.world_box.centre();
  s.camera.target = s.camera.position + Vec3d(1, 0, 0);
  EXPECT_TRUE(says(first_of(warnings(v, s)), "plan.camera_inside_cloud"));
}

TEST(Plan, DoubtsCamerasThatSeeNothing) {
  const Volume v = make_test_volume(field("gaussian"), 2, std::nullopt);
  CloudScene s = scene_around(v);
  EXPECT_EQ(warnings(v, s), "");
  CloudScene away = s;
  away.camera.target = s.camera.position * 2.0 - s.camera.target;
  EXPECT_TRUE(says(first_of(warnings(v, away)), "plan.none_rays_through"));
  s.options.width = 1024;
  s.options.crop_width = 16;
  EXPECT_TRUE(says(first_of(warnings(v, s)), "plan.none_rays_through"));
}

TEST(Plan, DoubtsCloudsLostInTheirBox) {
  const auto faint = [](const char* name, const Field& f, double extinction) {
    const Volume v = make_test_volume(f, extinction, std::nullopt);
    const std::string text = warnings(v, scene_around(v));
    EXPECT_TRUE(says(first_of(text), "plan.camera_rays_through")) << name << ": " << text;
  };
  // One voxel so far away that the frame around both shows neither, and one so dense that an
  // extinction chosen for it makes all others vanish.
  const Vec3i stray(200);
  faint("stray",
        make_field("stray", {0, 0, 0}, stray + Vec3i(1),
                   [&](Vec3i p) { return p == stray || dot(Vec3d(p), Vec3d(p)) < 9 ? 1.0 : 0.0; }),
        10);
  faint("hot",
        make_field("hot", {0, 0, 0}, {64, 64, 64},
                   [](Vec3i p) { return p == Vec3i(32) ? 1e30 : 1.0; }),
        1e-29);
}

/// A volume that lanes do not serve changes nothing of the others.
TEST(Plan, FlightsGoOneByOneThroughSomeVolumes) {
  std::vector<Volume> volumes;
  for (const double extinction : {1.0, 1e7}) {
    volumes.push_back(make_thick_volume(extinction, 1));
  }
  const CloudScene s = scene_around(volumes[0]);
  const RenderPlan p = plan(volumes, s.scene(), {.force = true, .forecast = false});
  ASSERT_EQ(p.one_by_one.size(), 2u);
  EXPECT_EQ(p.one_by_one[0], nullptr);
  ASSERT_NE(p.one_by_one[1], nullptr);
  EXPECT_EQ(decision(p, "flights").volume, 1);
  EXPECT_EQ(decision(p, "shadow rays").choice, "ratio");
}

TEST(Plan, ForecastCostsLittleHoweverThickTheCloudAndManyItsLights) {
  for (const double extinction : {1.0, 1e4, 1e8}) {
    const Volume v = make_thick_volume(extinction, 1);
    CloudScene s = scene_around(v);
    s.lights.assign(300, Sun{});
    RenderPlan p = plan(std::span(&v, 1), s.scene(), {.force = true});
    const detail::CameraProbe probe = detail::probe_camera(p);
    EXPECT_EQ(probe.paths > 0, extinction < 1e8) << "endless flights are not followed";
    std::uint64_t steps = 0;
    for (const Counter& c : kCounters) steps += value(c, probe.counts);
    // One path of 256 bounces with 300 shadow rays each may go beyond the million.
    EXPECT_LT(steps, 5e6) << extinction;
  }
}

}  // namespace plan_test
}  // namespace pvol::test
