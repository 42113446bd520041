// How pictures are estimated must not show in them: micro-bounds, weights, the choice of the
// transmittance's estimator, and the number of shadow rays.
#include "pvol/volume/estimators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"
#include "pvol/volume/extinction_source.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/effort.h"
#include "support/estimators.h"

namespace pvol::test {
namespace estimators_test {

constexpr MicroBoundsUse kUses[] = {MicroBoundsUse::edge_2, MicroBoundsUse::edge_1,
                                    MicroBoundsUse::automatic};

/// The field, optically 4 thick where it is dense, under two suns and a picture as sky.
CloudScene scene_of(const Field& field) {
  CloudScene s;
  s.medium = component(4.0 / std::min({field.size.x, field.size.y, field.size.z}),
                       Rgb(0.9f, 0.95f, 0.99f), 0.5, Rgb(0.1f));
  s.environment = ImageSky{2, 2, {Rgb(1.0f), Rgb(0.2f), Rgb(0.1f), Rgb(0.5f)}, Rgb(1.0f), 30};
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}, Sun{{-1, 0.2, 0.1}, Rgb(2.0f, 1.0f, 0.5f), 10}};
  s.options.width = s.options.height = 12;
  s.options.samples = 6;
  s.options.threads = 1;
  s.options.count = true;
  return s;
}

std::uint64_t lookups(const Counts& c) { return c.path.lookups + c.shadow.lookups; }

/// With all micro-bounds, the same picture for fewer look-ups; for as many where there is no cell
/// without both air and the densest sample.
void test_squeeze(const Field& field, const Pyramid& pyramid, CloudScene s) {
  s.options.micro_bounds = MicroBoundsUse::none;
  const Volume plain = make_volume(field.grid, pyramid, s);
  EXPECT_EQ(plain.density.squeeze_bytes(), 0u);
  s.camera = frame(plain.density.world_box, 1);
  const RenderResult reference = render(plain, s);
  for (const MicroBoundsUse use : kUses) {
    s.options.micro_bounds = use;
    const Volume volume = make_volume(field.grid, pyramid, s);
    const RenderResult squeezed = render(volume, s);
    const std::string name = field.name + ", " + label(s.options.tracker) + ", " +
                             label(s.options.transmittance) + ", micro-bounds " + pvol::name(use);
    EXPECT_TRUE(same_bytes(reference.film, squeezed.film)) << name;
    EXPECT_EQ(reference.counts.collisions, squeezed.counts.collisions) << name;
    EXPECT_EQ(reference.counts.path.null_collisions, squeezed.counts.path.null_collisions) << name;
    EXPECT_EQ(reference.counts.shadow_rays, squeezed.counts.shadow_rays) << name;
    EXPECT_LE(lookups(squeezed.counts), lookups(reference.counts)) << name;
    const bool is_thin = std::min({field.size.x, field.size.y, field.size.z}) == 1;
    if (volume.density.squeeze_bytes() > 0 && !is_thin && reference.counts.path.lookups > 100) {
      EXPECT_LT(squeezed.counts.path.lookups, reference.counts.path.lookups) << name;
    }
  }
}

TEST(Estimators, MicroBoundsChangeNoBit) {
  constexpr Tracker kAnalog[] = {Tracker::delta_global, Tracker::delta, Tracker::decomposition};
  for (const Field& f : fields()) {
    const Pyramid pyramid = build_pyramid(f.grid);
    CloudScene s = scene_of(f);
    for (const Tracker tracker : kAnalog) {
      for (const auto transmittance : {Transmittance::analog, Transmittance::ratio}) {
        s.options.tracker = tracker;
        s.options.transmittance = transmittance;
        ++s.options.seed;
        s.options.look_up = s.options.seed % 2 ? LookUp::nearest : LookUp::trilinear;
        const auto number = std::size_t(&f - fields().data());
        if (!proof::has_turn(number + std::size_t(tracker) + std::size_t(transmittance))) continue;
        test_squeeze(f, pyramid, s);
      }
    }
  }
}

TEST(Estimators, MicroBoundsOfSeveralVolumesChangeNoBit) {
  const Field& f = field("gaussian");
  CloudScene s = scene_of(f);
  s.options.kernel = KernelKind::scalar;
  std::vector<Body> media{s.medium, s.medium};
  media[1].object_to_world = translation({4, 5, -3});
  std::vector<std::vector<Volume>> all;
  for (const auto use : {MicroBoundsUse::none, MicroBoundsUse::edge_2, MicroBoundsUse::edge_1,
                         MicroBoundsUse::codes}) {
    s.options.micro_bounds = use;
    all.push_back(make_volumes(f, media, s));
  }
  all.push_back({all[1][0], all[0][1]});  // each volume uses those that it has
  all.push_back({all[1][0], all[2][1]});
  all.push_back({all[3][0], all[2][1]});
  s.camera = frame(all[0][0].density.world_box, 1);
  const RenderResult reference = render(all[0], s);
  for (std::size_t i = 1; i < all.size(); ++i) {
    const RenderResult r = render(all[i], s);
    EXPECT_TRUE(same_bytes(reference.film, r.film)) << i;
    EXPECT_LT(lookups(r.counts), lookups(reference.counts)) << i;
  }
}

TEST(Estimators, CountingChangesNoBit) {
  CloudScene s = scene_of(field("checkerboard"));
  for (const auto use : {MicroBoundsUse::none, MicroBoundsUse::edge_2, MicroBoundsUse::edge_1,
                         MicroBoundsUse::codes}) {
    s.options.micro_bounds = use;
    const Volume v = make_volumes(field("checkerboard"), std::vector{s.medium}, s).front();
    s.camera = frame(v.density.world_box, 1);
    s.options.count = true;
    const Film counted = render(v, s).film;
    s.options.count = false;
    EXPECT_TRUE(same_bytes(counted, render(v, s).film));
  }
}

/// 128^3 samples of density 1, whose leaves are uniform but for those at its faces.
const Field& block() {
  static const Field f = make_field(
      "block", {0, 0, 0}, {128, 128, 128}, [](Vec3i) { return 1.0; }, Tiles::edge_8);
  return f;
}

/// `automatic` has codes in pictures; nothing makes bounds where no tracker would ask.
TEST(Estimators, MicroBoundsAreBuiltWhereTheyAreOfUse) {
  const auto density = [](const Field& f, MicroBoundsUse use, Tracker tracker = Tracker::delta) {
    CloudScene s = scene_of(f);
    s.medium.extinction = 20;  // walks go down to the leaves
    s.options.samples = 10'000;
    s.options.micro_bounds = use;
    s.options.tracker = tracker;
    return make_volumes(f, std::vector{s.medium}, s).front().density;
  };
  const auto squeeze = [&](const auto&... choice) { return squeeze_of(density(choice...)); };
  const Field none = make_field("none", {0, 0, 0}, {3, 3, 3}, [](Vec3i) { return 0.0; });
  EXPECT_EQ(squeeze(field("contrast"), MicroBoundsUse::automatic), Squeeze::codes);
  EXPECT_EQ(squeeze(block(), MicroBoundsUse::automatic), Squeeze::codes);
  EXPECT_EQ(squeeze(field("contrast"), MicroBoundsUse::none), Squeeze::none);
  const VolumeField single = density(field("contrast"), MicroBoundsUse::edge_1);
  EXPECT_EQ(squeeze_of(single), Squeeze::micro_bounds);
  EXPECT_EQ(single.micro.edge, 1);
  const VolumeField cubes = density(block(), MicroBoundsUse::edge_2);
  EXPECT_EQ(squeeze_of(cubes), Squeeze::micro_bounds);
  EXPECT_EQ(cubes.micro.edge, 2);
  EXPECT_EQ(squeeze(block(), MicroBoundsUse::codes), Squeeze::codes);
  for (const Tracker t :
       {Tracker::weighted_delta, Tracker::weighted_decomposition, Tracker::regular}) {
    EXPECT_EQ(squeeze(field("contrast"), MicroBoundsUse::edge_1, t), Squeeze::none) << label(t);
    EXPECT_EQ(squeeze(field("contrast"), MicroBoundsUse::codes, t), Squeeze::none) << label(t);
  }
  for (const MicroBoundsUse use : kUses) EXPECT_EQ(squeeze(none, use), Squeeze::none);
}

/// Where bounds hold, weights are 1: samples of alpha are 0 or 1.
TEST(Estimators, WeightedTrackersAgreeWithAnalogOnes) {
  const Field& f = field("gaussian");
  CloudScene s = scene_of(f);
  s.options.samples = 60;
  s.camera = frame(make_volumes(f, std::vector{s.medium}, s).front().density.world_box, 1);
  const auto picture = [&](Tracker tracker, Transmittance transmittance) {
    s.options.tracker = tracker;
    s.options.transmittance = transmittance;
    ++s.options.seed;
    return render(make_volumes(f, std::vector{s.medium}, s).front(), s).film;
  };
  const Film analog = picture(Tracker::delta, Transmittance::analog);
  proof::Family family;
  for (const Tracker tracker : {Tracker::weighted_delta, Tracker::weighted_decomposition}) {
    for (const Transmittance transmittance : kTransmittances) {
      const Film film = picture(tracker, transmittance);
      compare(analog, film, std::string(label(tracker)) + ", " + label(transmittance), family);
      for (const PixelSums& p : film.pixels) EXPECT_EQ(p.alpha, std::round(p.alpha));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A volume whose bounds do not bound: majorants fall below the extinction, and minorants are near
/// them.
Volume with_wrong_bounds(Volume v) {
  for (Octree::Entry& e : v.density.octree.entries) {
    e.lo = 0.5f * e.hi;
    e.hi *= 0.8f;
  }
  return v;
}

/// Weights of both signs, then. Albedos so low that the roulette of paths meets all of them.
TEST(Estimators, WeightedTrackersNeedNoBounds) {
  constexpr Transmittance kUnbounded[] = {Transmittance::analog, Transmittance::ratio,
                                          Transmittance::residual_ratio, Transmittance::regular};
  proof::Family family;
  proof::Moments all;
  std::uint64_t number = 0;
  for (const Tracker tracker : {Tracker::weighted_delta, Tracker::weighted_decomposition}) {
    for (const Transmittance transmittance : kUnbounded) {
      for (const Rgb albedo : {Rgb(0.03f, 0.02f, 0.04f), Rgb(0.9f)}) {
        OneRay r({component(0.15, albedo, 0.3)}, {30, 25, 28}, {6, 6, 6});
        r.scene.lights = {Sun{{0.5, 0.7, -0.3}, Rgb(2.0f, 3.0f, 1.5f), 0}};
        r.scene.options.tracker = tracker;
        r.scene.options.transmittance = transmittance;
        r.scene.options.samples = proof::samples(100'000);
        r.scene.options.seed = ++number;
        const Volume v = with_wrong_bounds(make_volumes(cube(), r.bodies, r.scene).front());
        const Film film = render(v, r.scene).film;
        all.add(
            compare(r, film, std::string(label(tracker)) + ", " + label(transmittance), family));
        // Light behind shows the weights of flights that left; alpha is what they lack of 1.
        CloudScene lit = r.scene;
        lit.lights.clear();
        lit.environment = ConstantSky{Rgb(1.0f)};
        lit.options.max_bounces = 0;
        const Film behind = render(v, lit).film;
        const double passed = std::exp(-optical_depth(r.bodies, r.ray));
        compare(average(behind), {Vec3d(passed), Vec3d(0.0)}, "behind", family);
        EXPECT_NEAR(average_alpha(behind).mean.x, 1 - average(behind).mean.x, 1e-12);
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// One whose walks stop at leaves, where that pays and where it does not.
Octree octree_of_leaves(const Field& f, double extinction) {
  const Pyramid p = build_pyramid(f.grid);
  return build_octree(p, extinction, 1, {.everywhere = true}, build_field(f.grid, p).brick_of,
                      kZeroBrick);
}

/// The block's samples span 129^3 cells, in leaves of 136^3, 120^3 of them uniform. The mean
/// optical thickness over the chords of its box is 4 V / S mu.
TEST(Estimators, TheChoiceFollowsThicknessAndMinorants) {
  const auto choose = [](const Field& f, double extinction, int copies = 1, double size = 1) {
    const Body m = component(extinction, Rgb(1.0f), 0, {}, scaling(Vec3d(size)));
    const std::vector<Body> media(std::size_t(copies), m);
    std::vector<Volume> volumes = make_volumes(f, media, CloudScene{});
    for (Volume& v : volumes) v.density.octree = octree_of_leaves(f, extinction);
    return choose_transmittance(volumes);
  };
  const TransmittanceChoice thick = choose(block(), 1);
  EXPECT_EQ(thick.estimator, Transmittance::analog);
  EXPECT_NEAR(thick.thickness / (129 / 1.5), 0.5 * (1 + std::pow(120.0 / 129, 3)), 1e-3);
  EXPECT_NEAR(thick.control_share, std::pow(120.0 / 129, 3), 1e-3);
  const TransmittanceChoice thin = choose(block(), 0.04);
  EXPECT_EQ(thin.estimator, Transmittance::residual_ratio);
  EXPECT_NEAR(thin.thickness / thick.thickness, 0.04, 1e-4);
  EXPECT_EQ(choose(field("gaussian"), 0.1).estimator, Transmittance::ratio);
  EXPECT_EQ(choose(field("gaussian"), 20).estimator, Transmittance::analog);
  const TransmittanceChoice two = choose(block(), 0.04, 2);
  EXPECT_EQ(two.estimator, Transmittance::analog) << "together they are thick";
  EXPECT_NEAR(two.thickness / thin.thickness, 2, 1e-6);
  const TransmittanceChoice large = choose(block(), 0.002, 1, 20);
  EXPECT_EQ(large.estimator, Transmittance::residual_ratio) << "thickness is counted in the world";
  EXPECT_NEAR(large.thickness / thin.thickness, 1, 1e-6);
  EXPECT_EQ(choose_transmittance({}).estimator, Transmittance::ratio);
}

/// Majorants may be set too high, as for a study: the cloud is no thicker for it.
TEST(Estimators, ThicknessDoesNotDependOnTheScaleOfMajorants) {
  const Field f = field("gaussian");
  CloudScene s;
  s.medium = component(0.1, Rgb(1.0f), 0);
  const auto thickness = [&](double scale) {
    s.options.majorant_scale = scale;
    const std::vector<Volume> volumes = make_volumes(f, std::vector{s.medium}, s);
    return choose_transmittance(volumes).thickness;
  };
  EXPECT_NEAR(thickness(8) / thickness(1), 1, 1e-6);
}

TEST(Estimators, AutomaticIsTheOneItNames) {
  for (const char* name : {"constant", "gaussian", "contrast"}) {
    for (const double extinction : {0.01, 0.1, 2.0}) {
      CloudScene s = scene_of(field(name));
      s.medium.extinction = extinction;
      const Volume v = make_volumes(field(name), std::vector{s.medium}, s).front();
      s.camera = frame(v.density.world_box, 1);
      s.options.kernel = KernelKind::scalar;
      s.options.transmittance = Transmittance::automatic;
      const Film automatic = render(v, s).film;
      s.options.transmittance = choose_transmittance(std::span(&v, 1)).estimator;
      EXPECT_NE(s.options.transmittance, Transmittance::automatic);
      EXPECT_TRUE(same_bytes(automatic, render(v, s).film)) << name << ", " << extinction;
    }
  }
}

/// A phase function and suns, at angles to the view that make their light worth the shadow rays
/// that the comments say.
struct Valued {
  double g;
  std::vector<Sun> suns;
};
std::vector<Valued> valued_lights() {
  const Vec3d view = normalize(Vec3d(6, 6, 6) - Vec3d(30, 25, 28));
  const Vec3d across = normalize(cross(view, {0, 1, 0}));
  const auto at = [&](double cosine) {
    return view * cosine + across * std::sqrt(1 - cosine * cosine);
  };
  return {
      {0, {Sun{at(0.9), Rgb(3.0f), 0}}},                                  // 0.8
      {0.8, {Sun{at(0.9), Rgb(3.0f), 0}}},                                // 3.1
      {0.8, {Sun{at(0.999), Rgb(3.0f), 0}}},                              // 33: no more than 8
      {0.5, {Sun{at(0.95), Rgb(3.0f), 0}}},                               // 3.6
      {0, {Sun{at(0.3), Rgb(1.0f), 0}, Sun{at(0.9), Rgb(0.05f), 0}}},     // 0.76 and 0.04
      {0.7, {Sun{at(0.97), Rgb(1.0f), 0}, Sun{at(-0.9), Rgb(1.0f), 0}}},  // 7 and 0.05
      {-0.6, {Sun{at(-0.9), Rgb(2.0f, 0, 0), 0}, Sun{at(-1), Rgb(0, 0, 2.0f), 0}}},
  };
}

/// Shadow rays by value, unbiased and as many as they are worth. The estimate along a ray is exact
/// here, so that the counts of rays are all the noise there is beside the first flight's.
TEST(Estimators, ShadowRaysByValueKeepTheMean) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t number = 0;
  for (const Valued& lights : valued_lights()) {
    for (const Transmittance transmittance :
         {Transmittance::residual_ratio, Transmittance::analog}) {
      OneRay r({component(0.04, Rgb(1.0f), lights.g)}, {30, 25, 28}, {6, 6, 6});
      r.scene.lights.assign(lights.suns.begin(), lights.suns.end());
      r.scene.options.transmittance = transmittance;
      r.scene.options.samples =
          proof::samples(transmittance == Transmittance::analog ? 100'000 : 400'000);
      r.scene.options.seed = ++number;
      r.scene.options.count = true;
      const RenderResult result = render(make_volumes(cube(), r.bodies, r.scene).front(), r.scene);
      const std::string name = "lights " + std::to_string(number);
      all.add(compare(r, result.film, name, family));
      double light = 0, rays = 0, variance = 0;
      for (const Sun& sun : lights.suns) light += double(luminance(sun.irradiance));
      for (const Sun& sun : lights.suns) {
        const double value = double(luminance(sun.irradiance)) / (0.1 * light) *
                             phase(lights.g, dot(r.ray.d, normalize(sun.direction)));
        rays += value < 1 ? value : std::floor(std::min(value, 8.0));
        variance += value < 1 ? value * (1 - value) : 0;
      }
      // One collision scatters; the next ends the path.
      const double first = result.film.at(0, 0).alpha;
      const double excess = double(result.counts.shadow_rays) - rays * first;
      family.add(name + ", shadow rays",
                 variance == 0 ? double(excess == 0)
                               : proof::normal_p_value(excess / std::sqrt(variance * first)));
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Light adds up, with all orders of scattering, although more suns make each ray worth less.
TEST(Estimators, TwoSunsAreTheSumOfEach) {
  const Field& f = field("gaussian");
  CloudScene s = scene_of(f);
  s.environment = ConstantSky{Rgb(0.0f)};
  s.medium.emission = Rgb(0.0f);
  s.options.samples = proof::samples(300);
  std::get<Sun>(s.lights[1]).irradiance = Rgb(0.02f, 0.1f, 0.01f);
  std::get<Sun>(s.lights[1]).angle = 0;
  const Volume v = make_volumes(f, std::vector{s.medium}, s).front();
  s.camera = frame(v.density.world_box, 1);
  const auto light_of = [&](std::vector<Light> lights) {
    CloudScene lit = s;
    lit.lights = std::move(lights);
    lit.options.seed = ++s.options.seed;
    return average(render(v, lit).film);
  };
  proof::Family family;
  compare(light_of(s.lights), light_of({s.lights[0]}) + light_of({s.lights[1]}), "both", family);
  EXPECT_TRUE(family.passes());
}

}  // namespace estimators_test
}  // namespace pvol::test
