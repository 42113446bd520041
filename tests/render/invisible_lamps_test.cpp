// Lamps that the camera does not see shine all the same.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "pvol/render/render.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/pictures.h"

namespace pvol::test {
namespace invisible_lamps_test {

/// A thin puff between the camera and a ball and an area that shine at it.
struct Lit {
  CloudScene scene;
  Volume volume;
};
Lit lit_by(bool visible) {
  const Field& f = field("gaussian");
  Lit lit;
  CloudScene& s = lit.scene;
  s.medium = component(0.02, Rgb(0.8f), 0.3);
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = 16;
  s.options.samples = 32;
  s.options.aovs = {Aov::scattering};
  lit.volume = make_volume(f.grid, build_pyramid(f.grid), s);
  s.camera = frame(lit.volume.density.world_box, 1);
  const Vec3d middle = lit.volume.density.world_box.centre(), way = middle - s.camera.position;
  PointLight ball;
  ball.position = middle + way * 0.5 + s.camera.up * (0.2 * length(way));
  ball.radius = 0.1 * length(way);
  ball.intensity = Rgb(float(dot(way, way)));
  ball.visible_camera = visible;
  AreaLight area;
  area.position = middle + way * 0.5;
  area.direction = way * -1.0;
  area.size = std::array{0.2 * length(way), 0.2 * length(way)};
  area.radiance = Rgb(5.0f);
  area.visible_camera = visible;
  s.lights = {ball, area};
  return lit;
}

TEST(InvisibleLamps, LightTheSameAndAreNotSeen) {
  using Options = std::pair<GuideUse, LineLamps>;
  for (const auto& [guide, lines] :
       {Options{GuideUse::off, LineLamps::off}, Options{GuideUse::off, LineLamps::on},
        Options{GuideUse::on, LineLamps::off}, Options{GuideUse::on, LineLamps::on}}) {
    Lit seen = lit_by(true), unseen = lit_by(false);
    for (RenderOptions* o : {&seen.scene.options, &unseen.scene.options}) {
      o->guide = guide;
      o->line_lamps = lines;
    }
    const Film a = render(seen.volume, seen.scene).film;
    const Film b = render(unseen.volume, unseen.scene).film;
    EXPECT_EQ(layer(a, "single").sums, layer(b, "single").sums);
    EXPECT_EQ(layer(a, "multiple").sums, layer(b, "multiple").sums);
    double lamps = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      lamps += layer(a, "unscattered").sums[i].y;
      ASSERT_EQ(layer(b, "unscattered").sums[i], Vec3d()) << "pixel " << i;
      ASSERT_EQ(a.pixels[i].alpha, b.pixels[i].alpha);
    }
    EXPECT_GT(lamps, 0);
  }
}

TEST(InvisibleLamps, GoWithDeepPictures) {
  Lit seen = lit_by(true), unseen = lit_by(false);
  for (Lit* lit : {&seen, &unseen}) {
    lit->scene.options.aovs = {};
    lit->scene.options.background = false;
    lit->scene.options.line_lamps = LineLamps::off;  // as deep pictures
  }
  const Film flat = render(unseen.volume, unseen.scene).film;
  seen.scene.options.deep = unseen.scene.options.deep = true;
  EXPECT_TRUE(says(error_of([&] { (void)render(seen.volume, seen.scene); }), "deep.visible_lamps"));
  const Film deep = render(unseen.volume, unseen.scene).film;
  for (std::size_t i = 0; i < deep.pixels.size(); ++i) {
    ASSERT_EQ(deep.pixels[i].sum, flat.pixels[i].sum);
    const auto samples = deep_samples(deep.deep, i, deep.pixels[i].samples, 0);
    const DeepValue all = seen_before(samples, std::numeric_limits<double>::infinity());
    ASSERT_NEAR(all.colour.y, mean(deep.pixels[i]).y, 1e-4 * mean(deep.pixels[i]).y);
  }
}

}  // namespace invisible_lamps_test
}  // namespace pvol::test
