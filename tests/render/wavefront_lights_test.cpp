// What the lane kernels ask for one lane at a time: lamps, many lights, albedo fields, fires, thin
// media. Against flights one by one, and against themselves.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "pvol/math/direction.h"
#include "pvol/volume/emitter.h"
#include "render/engine/wavefront/wavefront.h"
#include "support/colors.h"
#include "support/lit_scenes.h"
#include "support/wavefront_shots.h"

namespace pvol::test {
namespace wavefront_lights_test {

void add_lamps(CloudScene& s) {
  s.lights.emplace_back(
      SpotLight{{60, 30, 40}, {-45, -15, -20}, Rgb(9e3f, 7e3f, 3e3f), 40, 0.5, ""});
  s.lights.emplace_back(PointLight{{20, 40, 18}, Rgb(300.0f, 200.0f, 400.0f), "", 4});
  s.lights.emplace_back(PointLight{{24, 20, 18}, Rgb(20.0f), "", 2});  // within
  s.lights.emplace_back(AreaLight{{-6, 16, 18}, {1, 0.1, 0}, {12, 9}, {0, 1, 0}, Rgb(4.0f), ""});
  s.lights.emplace_back(AreaLight{{20, 8, 20}, {0, 1, 0.3}, {6, 5}, {0, 0, 1}, Rgb(3.0f), ""});
}

std::shared_ptr<const Emitter> fire_of(const Field& field, const Fire& fire, const Affine& place) {
  const Pyramid pyramid = build_pyramid(field.grid);
  return std::make_shared<const Emitter>(make_emitter(fire, {field.grid, pyramid}, nullptr, place));
}

std::shared_ptr<const AlbedoField> stripes() {
  return albedo_of(make_colors({-8, -8, -8}, {64, 56, 56}, [](Vec3i p) {
    return Rgb(0.5f + 0.4f * float(p.x / 5 & 1), 0.9f, 0.3f + 0.6f * float(p.y / 7 & 1));
  }));
}

/// A dim picture of a sky with one bright pixel.
ImageSky bright_at(int x, int y, int width, int height) {
  ImageSky sky{width, height, std::vector<Rgb>(std::size_t(width * height), Rgb(0.02f))};
  sky.pixels.edit()[std::size_t(y * width + x)] = {90, 70, 40};
  return sky;
}

std::vector<Shot> shots(GuideUse first = GuideUse::on) {
  std::vector<Shot> all;
  const auto add = [&](const std::string& name, const auto& change, const auto& fill) {
    for (const GuideUse guide : guides_in_turn(all.size(), first)) {
      CloudScene s = sunny();
      s.options.guide = guide;
      change(s);
      Volume v = volume_of(s);
      fill(v);
      all.push_back({name_of(name, guide), s, {std::move(v)}});
    }
  };
  const auto grey = [](Volume&) {};
  const auto striped = [](Volume& v) { v.albedo = stripes(); };
  add("lamps", add_lamps, grey);
  add(
      "lamps, coloured",
      [](CloudScene& s) {
        add_lamps(s);
        s.medium.albedo = Rgb(0.9f, 0.97f, 0.6f);
        s.options.aovs = {Aov::lights, Aov::scattering};
      },
      grey);
  add(
      "many lights",
      [](CloudScene& s) {
        add_lamps(s);
        for (int i = 0; i < 90; ++i) {
          const Vec3d place = Vec3d(20, 16, 18) + direction_on_spiral(i, 90) * (25.0 + i % 7);
          s.lights.emplace_back(PointLight{place, Rgb(5.0f + float(i % 11), 8.0f, 9.9f)});
        }
        s.environment = GradientSky{};
      },
      grey);
  add(
      "an albedo of stripes", [](CloudScene&) {}, striped);
  add(
      "glowing stripes",
      [](CloudScene& s) {
        s.medium.emission = Rgb(0.2f, 1.0f, 0.5f);
        s.options.line_emission = LineEmission::off;
      },
      striped);
  const auto absorbing = [](CloudScene& s) { s.medium.albedo = Rgb(0.9f); };
  const Rgb flame(6.0f, 3.0f, 1.0f);
  add("a fire in the smoke", absorbing,
      [&](Volume& v) { v.fire = fire_of(puff(), {.intensity = 0.1, .color = flame}, {}); });
  add(
      "a fire that reaches out of the smoke",
      [](CloudScene& s) {
        s.medium.albedo = Rgb(0.9f);
        s.options.aovs = {Aov::lights, Aov::scattering};
      },
      [&](Volume& v) {
        v.fire = fire_of(puff(), {.intensity = 0.1, .color = flame},
                         translation({9, 11, -6}) * scaling(Vec3d(0.8)));
      });
  add(
      "a fire beside it, alone",
      [](CloudScene& s) {
        s.lights.clear();
        s.environment = ConstantSky{Rgb(0.0f)};
      },
      [&](Volume& v) {
        v.fire = fire_of(puff(), {.intensity = 3, .color = flame},
                         translation({60, 0, 0}) * scaling(Vec3d(0.3)));
      });
  add(
      "thin and glowing",
      [](CloudScene& s) {
        s.medium.extinction = 0.02;
        s.medium.albedo = Rgb(0.8f);
        s.medium.emission = Rgb(2.0f, 1.0f, 0.2f);
        s.options.line_emission = LineEmission::on;
      },
      grey);
  const auto under = [&](const std::string& name, const Environment& sky) {
    add(
        name,
        [&](CloudScene& s) {
          s.lights.clear();
          s.environment = sky;
          s.medium.g = 0;  // less noise
        },
        grey);
  };
  ImageSky aslant = bright_at(0, 2, 16, 8);
  aslant.rotation = 70;
  aslant.up = {0.5, -0.8, 0.2};
  under("a picture aslant", aslant);
  under("a picture bright at its pole", bright_at(4, 0, 9, 15));
  under("a picture of one row", bright_at(2, 0, 5, 1));
  under("a picture bright below", bright_at(6, 11, 9, 15));
  under("a clear sky with a low sun", ClearSky{.elevation = 2});
  return all;
}

TEST(WavefrontLights, HaveTheMeansOfFlightsOneByOne) {
  expect_means_of_flights_one_by_one(shots(), 400);
}
TEST(WavefrontLights, OfEveryWidthGiveTheSameBytes) {
  expect_same_at_every_width(shots(GuideUse::off));
}
TEST(WavefrontLights, CompanyChangesNoBit) { expect_same_in_any_company(shots()); }

/// Layers of lights add up to the picture, whichever way their light came.
TEST(WavefrontLights, LayersAddUp) {
  for (const KernelKind kernel : simd_kernels()) {
    for (const Shot& shot : shots()) {
      if (!shot.scene.options.aovs.has(Aov::lights)) continue;
      CloudScene s = shot.scene;
      s.options.samples = 30;
      const Film f = render_with(kernel, shot, s);
      for (std::size_t pixel = 0; pixel < f.pixels.size(); ++pixel) {
        Vec3d lights, orders;
        for (const Layer& layer : f.layers) {
          const bool order =
              layer.name == "unscattered" || layer.name == "single" || layer.name == "multiple";
          (order ? orders : lights) += layer.sums[pixel];
        }
        const Vec3d sum = f.pixels[pixel].sum;
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(lights[c], sum[c], 1e-4 * std::abs(sum[c]) + 1e-4) << shot.name;
          EXPECT_NEAR(orders[c], sum[c], 1e-4 * std::abs(sum[c]) + 1e-4) << shot.name;
        }
      }
    }
  }
}

}  // namespace wavefront_lights_test
}  // namespace pvol::test
