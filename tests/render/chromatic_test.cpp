// Extinction that differs by channel: each channel is the picture of a grey medium of its own.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/trackers.h"
#include "render/path/path_setup.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/moving_places.h"
#include "support/pictures.h"
#include "support/small_cloud.h"
#include "support/wavefront_shots.h"
#include "volume/chromatic_flights.h"

namespace pvol::test {
namespace chromatic_test {

Volume chromatic(const Field& field, const CloudScene& s, Rgb color) {
  Medium medium = s.medium.medium();
  medium.extinction_color = color;
  return pvol::make_volume(field.grid, build_pyramid(field.grid), medium, s.volume_options());
}

/// Channel c of a picture against that of a grey medium of that channel's extinction.
void compare_channels(const CloudScene& s, const Field& field, Rgb color, const std::string& name,
                      proof::Family& family) {
  const Volume v = chromatic(field, s, color);
  const Average colored = average(render({&v, 1}, s).film);
  for (int c = 0; c < 3; ++c) {
    CloudScene grey = s;
    grey.medium.extinction *= double(color[c]);
    grey.options.seed += 10 + std::uint64_t(c);
    const Average a = average(run(field, grey).film);
    const double difference = colored.mean[c] - a.mean[c];
    const double z = difference == 0  // where the channel sees nothing
                         ? 0
                         : difference / std::sqrt(colored.variance[c] + a.variance[c]);
    family.add(name + ", channel " + std::to_string(c), proof::normal_p_value(z));
  }
}

TEST(Chromatic, EachChannelIsTheGreyPictureOfItsExtinction) {
  proof::Family family;
  for (const Rgb color : {Rgb(1.0f, 0.5f, 0.1f), Rgb(0.3f, 0.9f, 1.0f), Rgb(0.0f, 1.0f, 0.02f)}) {
    CloudScene s = cloud_scene();
    s.options.samples = proof::samples(600);
    s.options.guide = GuideUse::off;
    compare_channels(s, cloud(), color, "sun and sky", family);
    s.lights = {PointLight{{9, 16, 8}, Rgb(300.0f)}};
    s.environment = ConstantSky{Rgb(0.3f)};
    s.medium.emission = Rgb(0.5f, 0.2f, 0.1f);
    s.options.line_emission = LineEmission::off;
    compare_channels(s, cloud(), color, "lamp and glow", family);
    s.options.line_emission = LineEmission::on;
    compare_channels(s, cloud(), color, "lamp and glow along flights", family);
    s.options.tracker = Tracker::delta;
    s.options.background = false;
    compare_channels(s, cloud(), color, "delta, transparent", family);
  }
  EXPECT_TRUE(family.passes());
}

/// What only kernels for many paths at once render: among surfaces, with lamps that are met,
/// guided.
TEST(Chromatic, EachChannelIsGreyBesideAllElse) {
  if (simd_kernels().empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  proof::Family family;
  const Rgb color(1.0f, 0.5f, 0.1f);
  CloudScene s = cloud_scene();
  s.options.samples = proof::samples(600);
  s.options.kernel = simd_kernels().back();
  s.options.guide = GuideUse::on;
  compare_channels(s, cloud(), color, "guided", family);
  const Box box = make_volume(cloud().grid, build_pyramid(cloud().grid), s).density.world_box;
  const PlaneSurface floor{{0, box.lo.y - 0.5, 0}, {0, 1, 0}, {Rgb(0.5f)}};
  const BallSurface ball{box.centre(), 0.2 * box.extent().x, {Rgb(0.6f)}};
  s.surfaces = {floor, ball};
  CloudScene caught = s, lamp = s;
  std::get<PlaneSurface>(caught.surfaces[0]).material.visibility = Visibility::shadow_catcher;
  std::get<BallSurface>(caught.surfaces[1]).material.visibility = Visibility::holdout;
  lamp.lights = {PointLight{box.centre() + Vec3d(0, box.extent().y, 0), Rgb(300.0f), "", 2}};
  lamp.medium.emission = Rgb(0.5f, 0.2f, 0.1f);
  std::size_t turn = 0;
  for (const auto& [scene, name] : {std::pair(&s, "ground and a ball"),
                                    {&caught, "a catcher and a holdout"},
                                    {&lamp, "a lamp that is met, and glow"}}) {
    for (const GuideUse guide : guides_in_turn(turn++, GuideUse::on)) {
      scene->options.guide = guide;
      compare_channels(*scene, cloud(), color, name_of(name, guide), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Under a sky alone, whose light comes to a catcher by shadow rays and by rays that it scatters.
TEST(Chromatic, ShadowsOfTheSkyAreThoseOfEachChannel) {
  if (simd_kernels().empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  proof::Family family;
  CloudScene s = cloud_scene();
  const Box box = make_volume(cloud().grid, build_pyramid(cloud().grid), s).density.world_box;
  PlaneSurface floor{{0, box.lo.y - 0.5, 0}, {0, 1, 0}, {Rgb(0.0f)}};
  floor.material.visibility = Visibility::shadow_catcher;
  s.surfaces = {floor};
  s.lights.clear();
  s.medium.albedo = Rgb(0.0f);
  s.options.guide = GuideUse::off;
  s.options.samples = proof::samples(9600);
  const Rgb color(1.0f, 0.3f, 0.05f);
  std::size_t turn = 0;
  for (const Tracker tracker : {Tracker::delta, Tracker::decomposition}) {  // alone, and in lanes
    s.options.tracker = tracker;
    ++turn;
    for (const Environment& sky : {Environment(GradientSky{Rgb(0.0f), Rgb(1.0f), Rgb(0.0f)}),
                                   Environment(ConstantSky{Rgb(1.0f)})}) {
      if (!proof::has_turn(++turn)) continue;
      s.environment = sky;
      compare_channels(s, cloud(), color, std::string(name(tracker)), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// What is seen through it is that of each channel; alpha is of their mean.
TEST(Chromatic, TransmittanceByChannelIsThatOfEach) {
  CloudScene s = cloud_scene();
  s.options.samples = proof::samples(100);
  s.options.guide = GuideUse::off;
  const Rgb color(1.0f, 0.5f, 0.1f);
  proof::Moments through[3], open[3];
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    CloudScene own = s;
    own.options.seed = seed;
    own.options.aovs.add(Aov::transmittance_rgb);
    const Volume v = chromatic(cloud(), own, color);
    const Film film = render({&v, 1}, own).film;
    const double pixels = double(film.pixels.size());
    Vec3d sum;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      sum += value(film.layers.at(0), film, i) / pixels;
    }
    EXPECT_NEAR(1 - average_alpha(film).mean.x, (sum.x + sum.y + sum.z) / 3, 1e-6);
    for (int c = 0; c < 3; ++c) {
      through[c].add(sum[c]);
      CloudScene grey = s;
      grey.options.seed = 100 + seed;
      grey.medium.extinction *= double(color[c]);
      open[c].add(1 - average_alpha(run(cloud(), grey).film).mean.x);
    }
  }
  EXPECT_GT(through[2].mean(), through[0].mean() + 0.1);
  proof::Family family;
  for (int c = 0; c < 3; ++c) {
    family.add("channel " + std::to_string(c), proof::equal_means_p_value(through[c], open[c]));
  }
  EXPECT_TRUE(family.passes());
}

TEST(Chromatic, WhiteFurnaceIsWhite) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(1.0f)};
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  s.options.samples = proof::samples(400);
  const Volume v = chromatic(cloud(), s, Rgb(1.0f, 0.4f, 0.05f));
  const Average a = average(render({&v, 1}, s).film);
  proof::Family family;
  compare(a, {Vec3d(1.0), Vec3d(0.0)}, "furnace", family, 1e-4);
  EXPECT_TRUE(family.passes());
}

/// Along one ray through a cube of density 1, by its walk.
struct CubeRay {
  Volume volume = make_test_volume(cube_of_leaves(), 1, 3, Tracker::delta, LookUp::nearest);
  Ray ray{{8.2, 7.9, 50}, {0, 0, -1}};
};

TEST(Chromatic, TransmittancesAreExponentials) {
  const CubeRay c;
  const double length = 16;  // of the ray in the cube
  const Rgb share(1.0f, 0.25f, 0.01f);
  for (const double extinction : {0.05, 0.5}) {
    const Volume v =
        make_test_volume(cube_of_leaves(), extinction, 3, Tracker::delta, LookUp::nearest);
    std::array<proof::Moments, 3> passed, survived;
    Rng rng(proof::seeded(3), 0, std::uint64_t(100 * extinction));
    detail::FlightMonitor monitor;
    for (int i = 0; i < 200'000; ++i) {
      auto walk = enter(v, c.ray);
      const Rgb t = detail::chromatic_transmittance(v.density, share, walk->local(), rng, monitor);
      auto again = enter(v, c.ray);
      const ChromaticFlight f =
          detail::fly_chromatic(v.density, share, Rgb(1.0f), again->local(), rng, monitor);
      for (int k = 0; k < 3; ++k) {
        passed[std::size_t(k)].add(double(t[k]));
        survived[std::size_t(k)].add(f.collided ? 0 : double(f.weight[k]));
      }
    }
    proof::Family family;
    for (std::size_t k = 0; k < 3; ++k) {
      const double expected = std::exp(-extinction * double(share[int(k)]) * length);
      family.add("pass", proof::mean_p_value(passed[k], expected, 1e-5));
      family.add("fly", proof::mean_p_value(survived[k], expected, 1e-5));
    }
    EXPECT_TRUE(family.passes());
  }
}

TEST(Chromatic, WeightsStayBoundedHoweverFarChannelsAreApart) {
  const Volume v = make_test_volume(cube_of_leaves(), 5, 3, Tracker::delta, LookUp::nearest);
  const Rgb share(1.0f, 1e-3f, 0.1f), throughput(1.0f, 1.0f, 1.0f);
  Rng rng(4, 0, 0);
  detail::FlightMonitor monitor;
  float most = 0;
  for (int i = 0; i < 100'000; ++i) {
    auto walk = enter(v, {{8.2, 7.9, 50}, {0, 0, -1}});
    const ChromaticFlight f =
        detail::fly_chromatic(v.density, share, throughput, walk->local(), rng, monitor);
    most = std::max(most, f.weight.x + f.weight.y + f.weight.z);
  }
  EXPECT_LE(most, 3 * 1.0001f) << "the sum over channels never grows";
}

/// Of two clouds that overlap, each has a colour of its own; one moves as a whole, or none does.
TEST(Chromatic, EachChannelOfSeveralVolumesIsGrey) {
  proof::Family family;
  CloudScene s = cloud_scene();
  s.options.samples = proof::samples(400);
  s.options.guide = GuideUse::off;
  for (const KernelKind kernel : {KernelKind::automatic, KernelKind::scalar}) {
    for (const bool moves : {false, true}) {
      s.options.kernel = kernel;
      s.camera.shutter = {0, moves ? 1.0 : 0.0};
      const auto picture = [&](Rgb of_first, Rgb of_second, double first, double second) {
        CloudScene each = s;
        each.medium.extinction = first * s.medium.extinction;
        std::vector<Volume> both{chromatic(cloud(), each, of_first)};
        each.medium.extinction = second * s.medium.extinction;
        each.medium.object_to_world = translation({7, 2, -3}) * s.medium.object_to_world;
        both.push_back(chromatic(cloud(), each, of_second));
        if (moves) {
          const auto places = alone(shifted({7, 2, -3}, {13, 2, -3}));
          both[1] = move_places(std::move(both[1]), places, s.camera.shutter);
        }
        ++s.options.seed;
        return average(render(both, s).film);
      };
      const Rgb a(1.0f, 0.5f, 0.1f), b(0.2f, 1.0f, 0.6f), grey(1.0f);
      const Average coloured = picture(a, b, 1, 1);
      for (int c = 0; c < 3; ++c) {
        const Average same = picture(grey, grey, double(a[c]), double(b[c]));
        const double z =
            (coloured.mean[c] - same.mean[c]) / std::sqrt(coloured.variance[c] + same.variance[c]);
        family.add(std::string(name(kernel)) + (moves ? ", moving, " : ", ") + std::to_string(c),
                   proof::normal_p_value(z));
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(Chromatic, GreyIsNotTouched) {
  const CloudScene s = cloud_scene();
  const Volume v = chromatic(cloud(), s, Rgb(1.0f));
  EXPECT_FALSE(detail::PathSetup(plan({&v, 1}, s.scene())).by_channel);
}

TEST(Chromatic, RefusesWhatDoesNotGoWithIt) {
  CloudScene s = cloud_scene();
  const Volume v = chromatic(cloud(), s, Rgb(1.0f, 0.5f, 0.5f));
  s.options.deep = true;
  EXPECT_TRUE(says(error_of([&] { (void)plan({&v, 1}, s.scene()); }), "albedo.colour_with_deep"));
  EXPECT_TRUE(says(error_of([&] { (void)chromatic(cloud(), s, Rgb(0.5f)); }),
                   "albedo.shares_extinction_channel"));
}

}  // namespace chromatic_test
}  // namespace pvol::test
