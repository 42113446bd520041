// Pictures of media whose albedo is a field: constants, closed forms, furnaces, places.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "support/colors.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/moving_places.h"
#include "support/pictures.h"
#include "support/small_cloud.h"
#include "support/velocities.h"

namespace pvol::test {
namespace albedo_picture_test {

using Color = std::function<std::optional<Rgb>(Vec3i)>;

/// Over the small cloud and the cube, with a rim.
ColorGrid colors_of(const Color& color) {
  return make_colors({-16, -16, -16}, {40, 40, 40}, color);
}

Volume tinted(const Field& field, const CloudScene& s, std::shared_ptr<const AlbedoField> albedo) {
  Volume v = make_volume(field.grid, build_pyramid(field.grid), s);
  v.albedo = std::move(albedo);
  return v;
}

CloudScene glowing_scene() {
  CloudScene s = cloud_scene();
  s.medium.emission = Rgb(0.3f, 1.0f, 0.1f);
  s.medium.others = {Component{0.25, Rgb(0.5f, 1.0f, 0.75f), HenyeyGreenstein(-0.3), Rgb(2.0f)}};
  s.options.samples = 16;
  return s;
}

/// The scene with the colour in the components' own albedos.
CloudScene times(CloudScene s, Rgb color) {
  s.medium.albedo = s.medium.albedo * color;
  for (Component& c : s.medium.others) c.albedo = c.albedo * color;
  return s;
}

TEST(AlbedoPicture, ConstantIsThatAlbedoToTheLastBit) {
  const Rgb color(0.75f, 0.5f, 0.125f);
  const auto albedo = albedo_of(colors_of([&](Vec3i) { return color; }));
  for (const Tracker tracker : {Tracker::decomposition, Tracker::delta, Tracker::weighted_delta}) {
    for (const LineEmission lines : {LineEmission::off, LineEmission::on}) {
      CloudScene s = glowing_scene();
      s.options.tracker = tracker;
      s.options.line_emission = lines;
      s.options.guide = GuideUse::off;
      if (lines == LineEmission::on) s.medium.emission = {}, s.medium.others.front().emission = {};
      s.options.aovs.add(Aov::lights);
      const Volume v = tinted(cloud(), s, albedo);
      const Film a = render({&v, 1}, s).film, b = run(cloud(), times(s, color)).film;
      EXPECT_TRUE(same_bytes(a, b)) << name(tracker) << ' ' << name(lines);
      ASSERT_EQ(a.layers.size(), b.layers.size());
      for (std::size_t i = 0; i < a.layers.size(); ++i) {
        EXPECT_TRUE(a.layers[i].sums == b.layers[i].sums) << a.layers[i].name;
      }
    }
  }
}

TEST(AlbedoPicture, ConstantIsThatAlbedoInEveryWayOfTracing) {
  const Rgb color(0.75f, 0.5f, 0.125f);
  const auto albedo = albedo_of(colors_of([&](Vec3i) { return color; }));
  proof::Family family;
  std::uint64_t seed = 0;
  for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
    for (const LineEmission lines : {LineEmission::off, LineEmission::on}) {
      CloudScene s = glowing_scene();
      s.options.samples = proof::samples(300);
      s.options.line_emission = lines;
      s.options.guide = guide;
      s.options.seed = ++seed;
      const Volume v = tinted(cloud(), s, albedo);
      CloudScene other = times(s, color);
      other.options.seed = ++seed;
      compare(render({&v, 1}, s).film, run(cloud(), other).film,
              std::string(name(guide)) + ' ' + name(lines), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(AlbedoPicture, ConstantIsThatAlbedoOfSeveralAndOfChromaticVolumes) {
  const Rgb color(0.75f, 0.5f, 0.125f);
  const auto albedo = albedo_of(colors_of([&](Vec3i) { return color; }));
  CloudScene s = glowing_scene();
  s.options.guide = GuideUse::off;
  s.options.line_emission = LineEmission::off;
  const CloudScene own = times(s, color);
  // One of two, and the other as it was.
  CloudScene aside = s;
  aside.medium.object_to_world = translation({9, 3, 0});
  const Volume beside = make_volume(cloud().grid, build_pyramid(cloud().grid), aside);
  const std::vector<Volume> varied{tinted(cloud(), s, albedo), beside};
  const std::vector<Volume> plain{make_volume(cloud().grid, build_pyramid(cloud().grid), own),
                                  beside};
  EXPECT_TRUE(same_bytes(render(varied, s).film, render(plain, s).film));
  // An extinction that differs by channel.
  Volume a = tinted(cloud(), s, albedo), b = plain.front();
  a.medium.extinction_color = b.medium.extinction_color = Rgb(1.0f, 0.5f, 0.25f);
  EXPECT_TRUE(same_bytes(render({&a, 1}, s).film, render({&b, 1}, s).film));
}

/// Light of a sun behind the camera that one scattering in the cube sends back: the closed form
/// along z from 15.5 down to -0.5, where the albedo is at + slope (z - 15.5) at depth 15.5 - z.
double returned(double mu, double at, double slope) {
  const double depth = 16, k = 2 * mu, e = std::exp(-k * depth);
  const double constant = (1 - e) / k, linear = (1 - e * (1 + k * depth)) / (k * k);
  return mu * (at * constant - slope * linear) / (4 * std::numbers::pi);
}

TEST(AlbedoPicture, LinearAcrossASlabIsItsClosedForm) {
  // Red rises towards the camera, green falls, blue goes across.
  const auto color = [](Vec3d p) {
    return Rgb(float(0.2 + p.z / 32), float(0.8 - p.z / 64), float(0.3 + p.x / 64));
  };
  const auto albedo = albedo_of(colors_of([&](Vec3i p) {
    const Rgb c = color(Vec3d(p));
    return Rgb(std::max(c.x, 0.0f), std::min(c.y, 1.0f), c.z);
  }));
  proof::Family family;
  std::uint64_t seed = 0;
  for (const double extinction : {0.01, 0.2}) {
    CloudScene s;
    s.camera.position = {6, 6, 90};
    s.camera.target = {6, 6, 6};
    s.camera.up = {1, 0, 0};
    s.camera.fov = 1e-4;
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights = {Sun{{0, 0, 1}, Rgb(10.0f), 0}};
    s.medium.extinction = extinction;
    s.medium.albedo = Rgb(0.9f, 0.5f, 1.0f);
    s.medium.g = 0;
    s.options.look_up = LookUp::nearest;
    s.options.width = s.options.height = 1;
    s.options.samples = 400'000;
    s.options.max_bounces = 1;
    s.options.threads = 2;
    s.options.seed = ++seed;
    const Volume v = tinted(cube_of_leaves(), s, albedo);
    const Average a = average(render({&v, 1}, s).film);
    const Rgb front = color({6, 6, 15.5});
    const Vec3d expected = Vec3d(returned(extinction, double(front.x), 1.0 / 32),
                                 returned(extinction, double(front.y), -1.0 / 64),
                                 returned(extinction, double(front.z), 0)) *
                           Vec3d(s.medium.albedo) * 10.0;
    compare(a, {expected, {}}, std::to_string(extinction), family, 1e-7);
    for (int c = 0; c < 3; ++c) {
      EXPECT_LT(std::sqrt(a.variance[c]) * 3, 0.03 * expected[c]) << "1 % would be seen";
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Bright and dark cells, some black, some that say nothing.
std::shared_ptr<const AlbedoField> patches(const Affine& place = {}) {
  return albedo_of(colors_of([](Vec3i p) -> std::optional<Rgb> {
                     const int cell = (p.x >> 2) * 3 + (p.y >> 2) * 5 + (p.z >> 2) * 7;
                     if (cell % 5 == 0) return std::nullopt;
                     return Rgb(float(cell & 3) / 3, float(cell & 7) / 7, float(cell % 4 == 0));
                   }),
                   nullptr, place);
}

/// What glows as the sky does is invisible before it, whatever it scatters and absorbs.
void expect_furnace(std::span<const Volume> volumes, const CloudScene& s, const std::string& name,
                    proof::Family& family) {
  const Rgb sky = std::get<ConstantSky>(s.environment).radiance;
  const Average a = average(render(volumes, s).film);
  compare(a, {Vec3d(sky), {}}, name, family, 1e-6);
  const double seen = proof::runs_all() ? 0.01 : 0.02;
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(std::sqrt(a.variance[c]) * 4, seen * double(sky[c])) << name << ": too few samples";
  }
}

TEST(AlbedoPicture, FurnaceIsInvisible) {
  proof::Family family;
  std::uint64_t seed = 0;
  for (const double extinction : {0.1, 0.6}) {
    for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
      for (const LineEmission lines : {LineEmission::off, LineEmission::on}) {
        CloudScene s = cloud_scene();
        s.lights = {};
        s.environment = ConstantSky{Rgb(0.5f, 1.0f, 2.0f)};
        s.medium.extinction = extinction;
        s.medium.emission = Rgb(0.5f, 1.0f, 2.0f);
        s.medium.others = {
            Component{0.25, Rgb(0.5f, 1.0f, 0.75f), HenyeyGreenstein(-0.3), s.medium.emission}};
        s.options.samples = proof::samples(700u);
        s.options.guide = guide;
        s.options.line_emission = lines;
        s.options.seed = ++seed;
        const Volume v = tinted(cloud(), s, patches());
        const std::string name = std::to_string(seed);
        expect_furnace({&v, 1}, s, name, family);
        if (guide == GuideUse::on) continue;
        Volume many = v;
        many.further_places = {translation({6, 2, -3}),
                               translation({-7, 4, 0}) * scaling({-0.5, 0.5, 0.5})};
        expect_furnace({&many, 1}, s, name + ", instances", family);
        Volume chromatic = v;
        chromatic.medium.extinction_color = Rgb(1.0f, 0.5f, 0.25f);
        expect_furnace({&chromatic, 1}, s, name + ", chromatic", family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(AlbedoPicture, EmissionOfWhatTheFieldAloneMakesAbsorb) {
  // Of albedo 1 nothing is emitted but by the colour; the field is seen along flights as well.
  const auto albedo = albedo_of(colors_of([](Vec3i) { return Rgb(0.5f, 1.0f, 0.0f); }));
  proof::Family family;
  for (const LineEmission lines : {LineEmission::off, LineEmission::on, LineEmission::automatic}) {
    CloudScene s = cloud_scene();
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights = {};
    s.medium.extinction = 0.05;
    s.medium.albedo = Rgb(1.0f);
    s.medium.emission = Rgb(2.0f);
    s.options.samples = proof::samples(600);
    s.options.line_emission = lines;
    s.options.guide = GuideUse::off;
    const Volume v = tinted(cloud(), s, albedo);
    const Average a = average(render({&v, 1}, s).film);
    EXPECT_EQ(a.mean.y, 0) << "nothing is absorbed";
    EXPECT_GT(a.mean.z, 0.1);
    s.options.seed = 99;
    compare(a, average(run(cloud(), times(s, Rgb(0.5f, 1.0f, 0.0f))).film), name(lines), family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(AlbedoPicture, EachPlaceLooksIntoItsOwnCells) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.options.samples = proof::samples(500);
  s.camera.position = {5, 8, 90};
  const std::vector<Affine> places{
      {},
      translation({14, 2, 0}) * scaling({-1, 1, 1}),
      Affine{{Vec3d{0, 0, 1}, Vec3d{0, 1, 0}, Vec3d{-1, 0, 0}}, {-13, -4, 3}}};
  Volume instances = tinted(cloud(), s, patches());
  std::vector<Volume> copies;
  for (const Affine& place : places) {
    if (copies.empty()) {
      copies.push_back(instances);
      continue;
    }
    instances.further_places.push_back(place);
    CloudScene own = s;
    own.medium.object_to_world = place;
    copies.push_back(tinted(cloud(), own, patches(place)));
  }
  proof::Family family;
  CloudScene other = s;
  other.options.seed = 5;
  compare(render({&instances, 1}, s).film, render(copies, other).film, "places", family);
  // A field that is not mirrored with its place is another picture.
  copies[1].albedo = patches();
  EXPECT_FALSE(same_bytes(render({&instances, 1}, s).film, render(copies, s).film));
  EXPECT_TRUE(family.passes());
}

TEST(AlbedoPicture, MovesWithTheDensity) {
  // At one time alone: half a frame of (16, 4, 0) voxels a frame.
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.options.samples = proof::samples(300);
  s.camera.shutter = {0.5, 0.5};
  const auto halves = [](const Affine& place) {
    return albedo_of(
        colors_of([](Vec3i p) { return p.x < 0 ? Rgb(1.0f, 0.2f, 0.1f) : Rgb(0.1f, 0.2f, 1.0f); }),
        nullptr, place);
  };
  const VelocityGrid wind =
      make_velocity({-64, -64, -64}, {64, 64, 64}, [](Vec3i) { return Vec3d(16, 4, 0); });
  const Pyramid pyramid = build_pyramid(cloud().grid);
  const Volume blown = make_moving(tinted(cloud(), s, halves({})), pyramid, {},
                                   {wind, 1, s.camera.shutter}, s.volume_options());
  CloudScene there = s;
  there.camera.shutter = {};
  there.medium.object_to_world = translation({8, 2, 0});
  there.options.seed = 3;
  const Volume moved = tinted(cloud(), there, halves(there.medium.object_to_world));
  proof::Family family;
  compare(render({&blown, 1}, s).film, render({&moved, 1}, there).film, "moved", family);
  EXPECT_TRUE(family.passes());
}

TEST(AlbedoPicture, MovesWithItsPlace) {
  // Even where the cloud is, and white beside it.
  const Rgb color(0.75f, 0.5f, 0.125f);
  const Vec3i lo = cloud().origin - Vec3i(2), hi = cloud().origin + cloud().size + Vec3i(1);
  const auto albedo =
      albedo_of(colors_of([&](Vec3i p) { return min(max(p, lo), hi) == p ? color : Rgb(1.0f); }));
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.options.kernel = KernelKind::scalar;
  s.camera.position = {20, 8, 120}, s.camera.target = {20, 0, 0};
  s.camera.shutter = {0, 1};
  const CloudScene even = times(s, color);
  const auto places = alone(shifted({0, 0, 0}, {40, 0, 0}));
  const Volume a = move_places(tinted(cloud(), s, albedo), places, s.camera.shutter);
  const Volume b = move_places(tinted(cloud(), even, nullptr), places, s.camera.shutter);
  EXPECT_TRUE(same_bytes(render({&a, 1}, s).film, render({&b, 1}, even).film));
}

/// The samples that collided, as the picture's layer of albedos has them.
double weight_of_layer(const Film& film) {
  double weight = 0;
  for (const double w : film.layers.at(0).weights) weight += w;
  return weight;
}
/// The mean over a picture of that layer.
Vec3d mean_of_layer(const Film& film) {
  Vec3d sum;
  for (const Vec3d& of_pixel : film.layers.at(0).sums) sum += of_pixel;
  EXPECT_GT(weight_of_layer(film), 0);
  return sum / weight_of_layer(film);
}

TEST(AlbedoPicture, IsInTheLayerOfAlbedos) {
  CloudScene s = cloud_scene();
  s.options.aovs.add(Aov::albedo);
  s.options.samples = 8;
  s.medium.albedo = Rgb(0.5f, 0.75f, 1.0f);
  const Volume v =
      tinted(cloud(), s, albedo_of(colors_of([](Vec3i) { return Rgb(0.5f, 0.25f, 0.125f); })));
  EXPECT_LT(length(mean_of_layer(render({&v, 1}, s).film) - Vec3d(0.25, 0.1875, 0.125)), 1e-6);
}

TEST(AlbedoPicture, LayerOfVolumesThatOverlapHasTheirMeanByExtinction) {
  CloudScene s = cloud_scene();
  s.options.aovs.add(Aov::albedo);
  s.options.samples = 1024;
  const std::vector<Body> media{component(0.1, Rgb(1.0f), 0), component(0.3, Rgb(0.2f), 0)};
  const Film film = render(make_volumes(cloud(), media, s), s).film;
  const double deviation = 0.8 * std::sqrt(0.25 * 0.75 / weight_of_layer(film));
  EXPECT_LT(deviation, 0.002);
  EXPECT_NEAR(mean_of_layer(film).x, 0.4, 4 * deviation);
}

TEST(AlbedoPicture, HasTheKernelsOfGreyOnes) {
  CloudScene s = cloud_scene();
  s.options.kernel = KernelKind::automatic;
  const Volume grey = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  const Volume v = tinted(cloud(), s, patches());
  EXPECT_EQ(plan({&v, 1}, s.scene()).kernel.kind, plan({&grey, 1}, s.scene()).kernel.kind);
}

TEST(AlbedoPicture, DarkMatterMayBeThick) {
  // Paths that would hardly end without the colour.
  const Field& block = field("constant");
  Volume v = make_test_volume(block, 5e4, std::nullopt, Tracker::decomposition);
  v.medium.components[0].albedo = Rgb(1.0f);
  CloudScene s;
  s.camera = frame(world_box({&v, 1}), 1);
  const auto refusal = [&] { return error_of([&] { (void)plan({&v, 1}, s.scene()); }); };
  EXPECT_TRUE(says(refusal(), "albedo.path_scatter_about_times"));
  const ColorGrid colors = colors_of([](Vec3i) { return Rgb(0.25f); });
  v.albedo = albedo_of(colors, &block.grid);
  EXPECT_EQ(refusal(), "");
}

}  // namespace albedo_picture_test
}  // namespace pvol::test
