// Shells in renders: they save work and change no bit of a picture.
#include <gtest/gtest.h>

#include <memory>

#include "pvol/density/recipe.h"
#include "pvol/render/render.h"
#include "pvol/render/shell_choice.h"
#include "pvol/shell/fit_shell.h"
#include "support/cloud_scene.h"
#include "support/effort.h"

namespace pvol {
namespace shell_render_test {

using test::CloudScene;

struct Sample {
  VoxelGrid grid;
  Pyramid pyramid;
  Support support;
  CloudScene scene;
  Volume volume;
};

/// A thin tilted ellipsoid: most of its box is empty.
Sample tilted_ellipsoid() {
  Affine turn;
  turn.m = {Vec3d{0.6, -0.8, 0}, Vec3d{0.8, 0.6, 0}, Vec3d{0, 0, 1}};
  Recipe recipe;
  recipe.forms = {FreeForm{0.1 * ellipsoid({}, {1, 0.2, 0.3}, turn), {}}};
  recipe.edge = 0.05;
  recipe.voxel = voxel_for(recipe, 48);
  Sample s;
  s.grid = make_grid(recipe);
  s.pyramid = build_pyramid(s.grid);
  s.support = make_support(s.grid, s.pyramid);
  s.scene.medium.extinction = 8;
  s.scene.medium.albedo = Rgb(0.9f);
  s.scene.lights = {Sun{}};
  s.scene.options.width = s.scene.options.height = 48;
  s.scene.options.samples = 4;
  s.scene.options.count = true;
  s.volume = make_volume(s.grid, s.pyramid, s.scene);
  s.scene.camera = frame(s.volume.density.world_box, 1);
  return s;
}

bool equal(const Film& a, const Film& b) {
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const PixelSums &p = a.pixels[i], &q = b.pixels[i];
    if (p.sum != q.sum || p.sum_squares != q.sum_squares || p.alpha != q.alpha) return false;
  }
  return a.pixels.size() == b.pixels.size();
}

TEST(ShellRender, RejectsRaysAndChangesNoBit) {
  Sample s = tilted_ellipsoid();
  std::size_t turn = 0;
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const Shell shell = fit_shell(s.support, {kind, 4});
    ++turn;
    for (const double distance : {0.0, 0.3, 1.0, 6.0}) {  // 0: from the middle of the cloud
      if (!proof::has_turn(++turn)) continue;
      CloudScene scene = s.scene;
      Camera& c = scene.camera;
      c.position = c.target + (c.position - c.target) * distance;
      if (distance == 0) c.target = c.position + Vec3d(1, 0.3, 0.2);
      s.volume.shell.reset();
      const RenderResult without = render(s.volume, scene);
      EXPECT_EQ(without.counts.shell_tests, 0u);
      scene.options.shells = ShellUse::on;
      s.volume.shell = std::make_shared<const Shell>(shell);
      EXPECT_TRUE(choose_shell(s.volume, scene.scene()).kept);
      const RenderResult with = render(s.volume, scene);
      EXPECT_TRUE(equal(without.film, with.film)) << distance;
      EXPECT_EQ(with.counts.collisions, without.counts.collisions);
      EXPECT_LE(with.counts.path.segments, without.counts.path.segments);
      EXPECT_GT(with.counts.shell_tests, 0u);
      if (distance >= 1) {
        EXPECT_GT(double(with.counts.shell_rejections), 0.3 * double(with.counts.shell_tests));
      }
      EXPECT_TRUE(distance > 0 || with.counts.shell_rejections == 0);
    }
  }
}

TEST(ShellRender, TheEstimateCountsWhatTheRenderDoes) {
  Sample s = tilted_ellipsoid();
  const Shell shell = fit_shell(s.support, {ShellKind::hard, 2});
  CloudScene scene = s.scene;
  scene.options.shells = ShellUse::on;
  s.volume.shell = std::make_shared<const Shell>(shell);
  const ShellChoice choice = choose_shell(s.volume, scene.scene());
  const Counts counts = render(s.volume, scene).counts;
  const double samples = 48 * 48 * 4, rays = choice.estimate.rays;
  EXPECT_NEAR(choice.estimate.boxed / rays, double(counts.shell_tests) / samples, 0.02);
  EXPECT_NEAR(choice.estimate.rejected / rays, double(counts.shell_rejections) / samples, 0.02);

  scene.camera.target = 2 * scene.camera.position - scene.camera.target;  // behind it
  const ShellEstimate away = choose_shell(s.volume, scene.scene()).estimate;
  EXPECT_EQ(away.rays, choice.estimate.rays);
  EXPECT_EQ(away.boxed, 0);
  EXPECT_EQ(away.rejected, 0);
  EXPECT_FALSE(away.pays());
}

TEST(ShellRender, AutomaticFollowsTheEstimate) {
  Sample s = tilted_ellipsoid();
  const Shell shell = fit_shell(s.support, {ShellKind::hard, 2});
  CloudScene scene = s.scene;
  scene.options.shells = ShellUse::automatic;
  s.volume.shell = std::make_shared<const Shell>(shell);
  ShellChoice choice = choose_shell(s.volume, scene.scene());
  EXPECT_EQ(choice.kept, choice.estimate.pays());
  const auto tests = [&] { return render(s.volume, scene).counts.shell_tests; };
  EXPECT_EQ(tests() > 0, choice.kept);

  // A camera amid the cloud rejects nothing: the shell cannot pay.
  scene.camera.position = scene.camera.target;
  scene.camera.target += Vec3d(1, 0, 0);
  choice = choose_shell(s.volume, scene.scene());
  EXPECT_EQ(choice.estimate.rejected, 0);
  EXPECT_FALSE(choice.kept);
  EXPECT_EQ(tests(), 0u);

  scene.options.shells = ShellUse::off;
  EXPECT_FALSE(choose_shell(s.volume, scene.scene()).kept);
}

}  // namespace shell_render_test
}  // namespace pvol
