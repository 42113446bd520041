// Several volumes and instances in the lane kernels: against flights one by one, and against
// themselves.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pvol/volume/emitter.h"
#include "support/colors.h"
#include "support/lit_scenes.h"
#include "support/wavefront_shots.h"

namespace pvol::test {
namespace wavefront_volumes_test {

/// The puff with a medium, at a place.
Volume puff_at(CloudScene s, const Body& body, const Affine& place) {
  s.medium = body;
  s.medium.object_to_world = place;
  return make_volume(puff().grid, build_pyramid(puff().grid), s);
}

std::vector<Shot> shots(GuideUse first = GuideUse::on) {
  std::vector<Shot> all;
  const auto add = [&](const std::string& name, CloudScene s, std::vector<Volume> volumes) {
    for (const GuideUse guide : guides_in_turn(all.size(), first)) {
      s.options.guide = guide;
      s.camera = Camera{{120, 60, 90}, {25, 16, 18}};
      s.camera.fov = 30;
      all.push_back({name_of(name, guide), s, volumes});
    }
  };
  const CloudScene plain = sunny();
  const Body grey = plain.medium, red = component(0.3, Rgb(0.95f, 0.7f, 0.4f), 0.2);
  const Affine aside = translation({30, 4, -6}) * scaling(Vec3d(0.8)),
               apart = translation({70, 0, 0});
  const Volume one = puff_at(plain, grey, {});
  add("two apart", plain, {one, puff_at(plain, grey, apart)});
  add("two that overlap", plain, {one, puff_at(plain, red, aside)});
  Volume many = one;
  for (int i = 1; i < 12; ++i) {
    many.further_places.push_back(translation({11.0 * i - 60, 3.0 * (i % 5), 17.0 * (i % 3)}) *
                                  scaling(Vec3d(0.3 + 0.05 * i, 0.5, 0.4)));
  }
  add("instances", plain, {many});
  CloudScene ratio = plain, nearest = plain, lamps = plain;
  ratio.options.transmittance = Transmittance::ratio;
  add("shadow rays by ratio", ratio, {one, puff_at(ratio, red, aside)});
  lamps.lights = {PointLight{{30, 20, 18}, Rgb(400.0f), "", 3},
                  PointLight{{60, 30, 40}, Rgb(6e3f)}};
  lamps.environment = GradientSky{};
  lamps.options.aovs = {Aov::lights, Aov::scattering};
  add("lamps and layers", lamps, {one, puff_at(lamps, red, aside)});
  Volume striped = puff_at(plain, red, aside);
  striped.albedo = albedo_of(make_colors({-80, -80, -80}, {160, 160, 160}, [](Vec3i p) {
    return Rgb(0.5f + 0.4f * float(p.x / 5 & 1), 0.9f, 0.3f);
  }));
  add("an albedo of stripes in one", plain, {one, striped});
  Volume burning = puff_at(plain, red, aside);
  const Pyramid pyramid = build_pyramid(puff().grid);
  burning.fire = std::make_shared<const Emitter>(make_emitter(
      {.intensity = 0.1, .color = Rgb(6.0f, 3.0f, 1.0f)}, {puff().grid, pyramid}, nullptr, aside));
  add("a fire in one", plain, {one, burning});
  nearest.options.look_up = LookUp::nearest;
  add("nearest", nearest, {puff_at(nearest, grey, {}), puff_at(nearest, red, aside)});
  return all;
}

TEST(WavefrontVolumes, HaveTheMeansOfFlightsOneByOne) {
  expect_means_of_flights_one_by_one(shots(), 600);
}
TEST(WavefrontVolumes, OfEveryWidthGiveTheSameBytes) {
  expect_same_at_every_width(shots(GuideUse::off));
}
TEST(WavefrontVolumes, CompanyChangesNoBit) { expect_same_in_any_company(shots()); }

/// A volume in two halves of its extinction is the volume.
TEST(WavefrontVolumes, OfHalfTheExtinctionAddUp) {
  CloudScene s = sunny();
  s.options.samples = proof::samples(2000);
  s.camera = Camera{{120, 60, 90}, {20, 16, 18}};
  s.camera.fov = 30;
  Body half = s.medium;
  half.extinction /= 2;
  const Film whole = render(std::vector{puff_at(s, s.medium, {})}, s).film;
  s.options.seed = 2;
  const Film halves = render(std::vector{puff_at(s, half, {}), puff_at(s, half, {})}, s).film;
  proof::Family family;
  compare(whole, halves, "halves", family);
  EXPECT_TRUE(family.passes());
}

}  // namespace wavefront_volumes_test
}  // namespace pvol::test
