// Layers of light: their sum is the picture, and each is what its light alone gives.
#include <gtest/gtest.h>

#include <array>

#include "pvol/render/render.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/pictures.h"
#include "support/statistics.h"

namespace pvol::test {
namespace layers_test {

/// A glowing cloud in two suns, one with a disc, under a picture of a sky or an even one.
CloudScene lit_scene(bool even, GuideUse guide) {
  CloudScene s;
  s.medium.extinction = 2;
  s.medium.albedo = Rgb(0.9f, 0.8f, 0.95f);
  s.medium.emission = Rgb(0.5f, 0.2f, 0.1f);
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}, Sun{{-1, 0.2, 0.1}, Rgb(2.0f, 1.0f, 0.5f), 25}};
  if (even) {
    s.environment = ConstantSky{Rgb(0.4f)};
  } else {
    ImageSky sky;
    sky.width = 4, sky.height = 2;
    for (int i = 0; i < 8; ++i) sky.pixels.edit().emplace_back(0.1f * float(i));
    s.environment = sky;
  }
  s.options.width = s.options.height = 12;
  s.options.samples = 400;
  s.options.guide = guide;
  s.options.aovs = {Aov::lights};
  return s;
}

Volume cloud_for(CloudScene& s) {
  const Field& f = field("gaussian");
  s.medium.extinction = 0.3;
  Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
  s.camera = frame(v.density.world_box, 1);
  return v;
}

TEST(Layers, AreThereWhereTheyAreAskedForAndSumUpToThePicture) {
  for (const bool even : {true, false}) {
    for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
      CloudScene s = lit_scene(even, guide);
      s.options.samples = 20;
      const Volume v = cloud_for(s);
      const Film film = render(v, s).film;
      ASSERT_EQ(film.layers.size(), 4u);
      EXPECT_EQ(film.layers[0].name, "sun_1");
      EXPECT_EQ(film.layers[1].name, "sun_2");
      EXPECT_EQ(film.layers[2].name, "sky");
      EXPECT_EQ(film.layers[3].name, "emission");
      for (std::size_t i = 0; i < film.pixels.size(); ++i) {
        Vec3d sum;
        double size = 0;
        for (const Layer& layer : film.layers) {
          sum += layer.sums[i];
          size += length(layer.sums[i]);
        }
        ASSERT_LE(length(sum - film.pixels[i].sum), 1e-5 * size) << i;
      }
      s.options.aovs = {};
      const Film plain = render(v, s).film;
      EXPECT_TRUE(plain.layers.empty());
      for (std::size_t i = 0; i < film.pixels.size(); ++i) {
        ASSERT_EQ(film.pixels[i].sum, plain.pixels[i].sum) << "asking changes the picture";
      }
    }
  }
}

/// Mean over the pixels of each picture of a layer, by seed.
TEST(Layers, EachIsThePictureOfItsLightAlone) {
  proof::Family family;
  for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
    std::array<proof::Moments, 4> differences;
    for (std::uint64_t seed = 1; seed <= proof::samples(24u); ++seed) {
      CloudScene s = lit_scene(false, guide);
      s.options.samples = 60;
      s.options.seed = seed;
      const Volume v = cloud_for(s);
      const Film all = render(v, s).film;
      for (std::size_t layer = 0; layer < 4; ++layer) {
        CloudScene alone = s;
        alone.options.seed = 1000 + seed;
        alone.options.aovs = {};
        alone.lights.clear();
        if (layer < 2) alone.lights = {s.lights[layer]};
        if (layer != 2) alone.environment = ConstantSky{Rgb(0.0f)};
        if (layer != 3) alone.medium.emission = Rgb(0.0f);
        const Film one = render(v, alone).film;
        Vec3d sum;
        for (std::size_t i = 0; i < all.pixels.size(); ++i) {
          sum += all.layers[layer].sums[i] - one.pixels[i].sum;
        }
        differences[layer].add(sum.x + sum.y + sum.z);
      }
    }
    for (std::size_t layer = 0; layer < 4; ++layer) {
      family.add(std::string(name(guide)) + ", layer " + std::to_string(layer),
                 proof::mean_p_value(differences[layer], 0));
    }
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace layers_test
}  // namespace pvol::test
