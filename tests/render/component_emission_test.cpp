// Emission of components, which is that of their mean: how much of a medium glows makes no difference,
// only how much light that is.
#include <gtest/gtest.h>

#include "pvol/volume/make_volume.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace component_emission_test {

Film picture(CloudScene s, double share, LineEmission lines, std::uint64_t seed) {
  Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  Component glows = v.medium.components.front();
  glows.share = share;
  glows.albedo = Rgb(0.0f);
  glows.emission = Rgb(float(3 / share), float(2 / share), float(1 / share));
  v.medium.components.front().share = 1 - share;
  v.medium.components.push_back(glows);
  s.options.line_emission = lines;
  s.options.seed = seed;
  return render({&v, 1}, s).film;
}

TEST(ComponentEmission, IsThatOfTheMeanHoweverSmallTheShareIs) {
  proof::Family family;
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.environment = ConstantSky{Rgb(0.0f)};
  s.medium.extinction = 2;
  s.medium.albedo = Rgb(0.5f);
  s.options.samples = proof::samples(600);
  const Film half = picture(s, 0.5, LineEmission::on, 1);
  // Half of the rest scatters: of a share of 1/2 a quarter, of a tiny one half.
  const Film tiny = picture(s, 1e-9, LineEmission::on, 2);
  std::uint64_t seed = 3;
  for (const double share : {1e-9, 3e-8, 1e-6}) {
    compare(average(picture(s, share, LineEmission::off, seed++)), average(tiny),
            "share " + std::to_string(share), family);
  }
  compare(average(picture(s, 0.5, LineEmission::off, seed++)), average(half), "half", family);
  EXPECT_TRUE(family.passes());
}

}  // namespace component_emission_test
}  // namespace pvol::test
