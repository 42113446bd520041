// Light of emission along flights: closed forms, and other ways to the same picture.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/volume/emitter.h"
#include "render/light/emission/emission_setup.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace fire_test {

/// The field as a fire of constant colour.
std::shared_ptr<const Emitter> fire_of(const Field& field, const Fire& fire,
                                       const Affine& place = {}) {
  const Pyramid pyramid = build_pyramid(field.grid);
  return std::make_shared<const Emitter>(make_emitter(fire, {field.grid, pyramid}, nullptr, place));
}

/// The same fire, of which lanes look up nothing: they have no index of its leaves.
std::shared_ptr<const Emitter> without_lanes(Emitter e) {
  e.field.leaves = nullptr;
  return std::make_shared<const Emitter>(std::move(e));
}

/// Nothing at all, around which a fire may be.
Volume emptiness(const CloudScene& scene) { return make_volume(VoxelGrid{}, Pyramid{}, scene); }

/// Constant 1 in [3, 29]^3, with a rim of one voxel over which it falls to 0.
const Field& block() {
  static const Field f = make_field("block", {3, 3, 3}, {27, 27, 27}, [](Vec3i) { return 1.0; });
  return f;
}

CloudScene dark(Vec3d from, Vec3d to) {
  CloudScene s;
  s.camera.position = from;
  s.camera.target = to;
  s.camera.fov = 1e-4;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = 1;
  s.options.samples = 4096;
  s.options.threads = 1;
  return s;
}

TEST(Fire, AloneIsItsIntegralAlongTheRay) {
  // Across the block: 26 voxels of 1 and half a voxel of each rim.
  const Fire fire{.intensity = 0.5, .color = Rgb(1.0f, 0.25f, 4.0f)};
  const std::shared_ptr<const Emitter> in_lanes = fire_of(block(), fire);
  ASSERT_NE(in_lanes->field.leaves, nullptr);
  for (const auto& emitter : {in_lanes, without_lanes(*in_lanes)}) {
    for (const int points : {1, 8}) {
      CloudScene s = dark({16, 16, 90}, {16, 16, 16});
      s.options.emission_points = points;
      Volume v = emptiness(s);
      v.fire = emitter;
      const Average a = average(render({&v, 1}, s).film);
      for (int c = 0; c < 3; ++c) {
        const double expected = 0.5 * double(fire.color[c]) * 27;
        EXPECT_NEAR(a.mean[c], expected, 5 * std::sqrt(a.variance[c]) + 1e-5 * expected);
        EXPECT_LT(std::sqrt(a.variance[c]), 2e-3 * expected) << "the points are spread";
      }
    }
  }
}

/// As a simulation writes one before it burns.
TEST(Fire, ThatIsZeroEverywhereLeavesThePictureAsItIs) {
  CloudScene s;
  s.options.width = 12, s.options.height = 8, s.options.samples = 4;
  const Field& smoke = cloud();
  Volume v = make_volume(smoke.grid, build_pyramid(smoke.grid), s);
  const Film without = render({&v, 1}, s).film;
  const VoxelGrid nothing;
  v.fire = std::make_shared<const Emitter>(make_emitter({}, {nothing, Pyramid{}}, nullptr, {}));
  for (const LineEmission lines : {LineEmission::automatic, LineEmission::on, LineEmission::off}) {
    s.options.line_emission = lines;
    EXPECT_TRUE(same_bytes(render({&v, 1}, s).film, without));
  }
}

TEST(Fire, SphereIsItsChord) {
  // The map makes a ball of one value of a field that falls with the radius.
  const Field cone = make_field("cone", {-20, -20, -20}, {41, 41, 41},
                                [](Vec3i p) { return std::max(0.0, 1 - length(Vec3d(p)) / 20); });
  const Fire fire{.map = {.ramp = {{{0, 0}, {0.4f, 0}, {0.4001f, 1}}, false}}, .intensity = 2};
  for (const double aside : {0.0, 5.0, 10.0}) {
    CloudScene s = dark({aside, 0, 80}, {aside, 0, 0});
    s.options.emission_points = 8;
    Volume v = emptiness(s);
    v.fire = fire_of(cone, fire);
    const Average a = average(render({&v, 1}, s).film);
    const double chord = 2 * std::sqrt(12 * 12 - aside * aside);  // 1 - r / 20 = 0.4
    EXPECT_NEAR(a.mean.x / (2 * chord), 1, 0.012) << "but for the lattice, off centre " << aside;
  }
}

/// A cube of extinction that absorbs, with a fire over it, in it and beyond it.
TEST(Fire, SlabThatAbsorbsIsItsClosedForm) {
  proof::Family family;
  std::uint64_t seed = 0;
  for (const double extinction : {0.002, 0.1, 1.0}) {
    for (const Tracker tracker :
         {Tracker::decomposition, Tracker::delta, Tracker::weighted_delta, Tracker::regular}) {
      // The cube fills [-0.5, 15.5]; the fire is 1 in [3, 29] but for its rims: along z 13.5 voxels
      // of it lie before the cube as the camera sees it, and 12.5 and a rim within.
      CloudScene s = dark({6, 6, 90}, {6, 6, 6});
      s.medium.extinction = extinction;
      s.medium.albedo = Rgb(0.0f);
      s.options.look_up = LookUp::nearest;
      s.options.tracker = tracker;
      s.options.samples = proof::samples(40'000);
      s.options.seed = ++seed;
      Volume v = make_volume(cube_of_leaves().grid, build_pyramid(cube_of_leaves().grid), s);
      v.fire = fire_of(block(), {.intensity = 3});
      const Average a = average(render({&v, 1}, s).film);
      const double before = 13.5 + 0.5;  // with half a voxel of the rim
      // Within: 1 from 15.5 down to 3, then a rim of a voxel, (z - 2) from 3 to 2.
      const double mu = extinction, full = 15.5 - 3;
      const double within = -std::expm1(-mu * full) / mu;
      const double e = std::exp(-mu), rim = std::exp(-mu * full) * (1 - (1 - e) / mu) / mu;
      compare(a, {Vec3d(3 * (before + within + rim)), {}},
              std::string(name(tracker)) + " " + std::to_string(extinction), family, 1e-4);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A scene whose medium glows, once by collisions and once along flights, which are told how.
RenderResult glow(std::span<const Volume> volumes, CloudScene s, LineEmission lines,
                  std::uint64_t seed) {
  s.options.line_emission = lines;
  s.options.seed = seed;
  return render(volumes, s);
}

TEST(LineEmission, IsTheSamePictureAsAtCollisions) {
  proof::Family family;
  std::uint64_t seed = 50;
  for (const double extinction : {0.01, 0.2, 2.0}) {
    for (const float albedo : {0.0f, 0.8f}) {
      for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
        CloudScene s = cloud_scene();
        s.medium.extinction = extinction;
        s.medium.albedo = Rgb(albedo);
        s.medium.emission = Rgb(5.0f, 1.0f, 0.2f);
        s.options.samples = proof::samples(400);
        s.options.guide = guide;
        const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
        seed += 2;
        compare(glow({&v, 1}, s, LineEmission::on, seed).film,
                glow({&v, 1}, s, LineEmission::off, seed + 1).film,
                std::to_string(extinction) + " " + std::to_string(albedo), family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A medium that glows and does not scatter, as each look-up sees it: L (1 - e^-tau).
TEST(LineEmission, OfASlabIsItsClosedForm) {
  proof::Family family;
  CloudScene s = dark({16, 16 + 90 * 0.2, 106}, {16, 16, 16});
  s.medium.albedo = Rgb(0.0f);
  s.medium.emission = Rgb(3.0f, 1.0f, 0.0f);
  s.options.line_emission = LineEmission::on;
  s.options.samples = 20'000;
  using enum SampleStorage;
  for (const auto& [look_up, samples] : {std::pair(LookUp::nearest, copied),
                                         {LookUp::nearest, shared},
                                         {LookUp::trilinear, copied},
                                         {LookUp::trilinear, shared},
                                         {LookUp::tricubic, copied}}) {
    for (const double tau : {1e-4, 0.5}) {
      // Through 26 voxels of 1 and half a voxel of each rim, aslant.
      s.medium.extinction = tau / (27 * std::hypot(1, 0.2));
      s.options.look_up = look_up;
      ++s.options.seed;
      VolumeOptions o = s.volume_options();
      o.samples = samples;
      const Pyramid pyramid = build_pyramid(block().grid, look_up);
      const Volume v = make_volume(block().grid, pyramid, s.medium.medium(), o);
      compare(average(render({&v, 1}, s).film), {-std::expm1(-tau) * Vec3d(3, 1, 0), {}},
              std::to_string(int(look_up)) + " " + std::to_string(tau), family, 1e-7);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// The same of wisps of a voxel each, of which walks meet parts of leaves.
TEST(LineEmission, OfWispsIsTheSamePicture) {
  const Field wisps = make_field("wisps", {-24, -24, -24}, {48, 48, 48}, [](Vec3i p) {
    const bool one = (p.x & 7) == 5 && (p.y & 7) == 3 && (p.z & 7) == 6;
    return one ? 0.5 + 0.01 * (p.x + 24) : 0.0;
  });
  proof::Family family;
  CloudScene s = cloud_scene();
  s.medium.extinction = 2;
  s.medium.emission = Rgb(5.0f, 1.0f, 0.2f);
  s.options.samples = proof::samples(400);
  const Volume v = make_volume(wisps.grid, build_pyramid(wisps.grid), s);
  compare(glow({&v, 1}, s, LineEmission::on, 91).film, glow({&v, 1}, s, LineEmission::off, 92).film,
          "wisps", family);
  EXPECT_TRUE(family.passes());
}

/// Smoke beside a medium that glows and does not scatter: its light on the smoke is sampled where
/// it is gathered along flights, and met by chance at collisions.
TEST(LineEmission, LightsOtherVolumes) {
  proof::Family family;
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.0f)};
  s.lights.clear();
  s.camera.position = {0, 5, 70};
  s.camera.fov = 40;
  s.options.samples = proof::samples(1500);
  s.options.guide = GuideUse::off;  // which helps paths that meet it by chance alone
  CloudScene glowing = s;
  glowing.medium.albedo = Rgb(0.0f);
  glowing.medium.emission = Rgb(800.0f, 400.0f, 200.0f);
  glowing.medium.extinction = 0.05;
  glowing.medium.object_to_world = translation({17, 2, 3}) * scaling(Vec3d(0.35));
  s.medium.extinction = 0.3;
  const Pyramid pyramid = build_pyramid(cloud().grid);
  const std::vector<Volume> both{make_volume(cloud().grid, pyramid, s),
                                 make_volume(cloud().grid, pyramid, glowing)};
  const RenderResult lines = glow(both, s, LineEmission::on, 71);
  // Some two paths of a quarter of the picture meet it by chance in these: a mean takes more.
  constexpr int kMore = 20;
  s.options.samples *= kMore;
  const RenderResult chance = glow(both, s, LineEmission::off, 72);
  compare(lines.film, chance.film, "beside", family);
  EXPECT_TRUE(family.passes());
  // The left half sees smoke alone, lit from the right: far less noise.
  const auto left = [](const Film& f) { return average(f, 0, 0, f.crop_width / 2, f.crop_height); };
  EXPECT_LT(left(lines.film).variance.y, 0.1 * kMore * left(chance.film).variance.y);
}

TEST(Fire, OfTheDensityIsMatterThatGlows) {
  // mu_a L_e as a fire of the density's grid, against the medium's own emission.
  proof::Family family;
  CloudScene s = cloud_scene();
  s.medium.albedo = Rgb(0.75f);
  s.options.samples = proof::samples(800);
  Volume by_fire = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  by_fire.fire =
      fire_of(cloud(), {.intensity = s.medium.extinction * 0.25, .color = Rgb(6.0f, 3.0f, 1.0f)});
  CloudScene by_matter = s;
  by_matter.medium.emission = Rgb(6.0f, 3.0f, 1.0f);
  by_matter.options.line_emission = LineEmission::off;
  by_matter.options.seed = 9;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), by_matter);
  compare(render({&by_fire, 1}, s).film, render({&v, 1}, by_matter).film, "fire", family);
  EXPECT_TRUE(family.passes());
}

/// Where smoke is cold it may be thin: its leaves are not left to lines, which would bring nothing.
TEST(Fire, ThatIsColdHereAndThereLeavesNothingToLines) {
  const Field smoke =
      make_field("smoke", {0, 0, 0}, {24, 8, 8}, [](Vec3i at) { return at.x < 8 ? 0.001 : 1.0; });
  const Field heat =
      make_field("heat", {0, 0, 0}, {24, 8, 8}, [](Vec3i at) { return at.x < 12 ? 0.1 : 0.9; });
  CloudScene s = cloud_scene();
  s.options.line_emission = LineEmission::off;
  Volume v = make_volume(smoke.grid, build_pyramid(smoke.grid), s);
  const Ramp warm{{{0.5f, 0}, {1, 1}}, false};
  const Pyramid of_smoke = build_pyramid(smoke.grid), of_heat = build_pyramid(heat.grid);
  const BoundedGrid color{heat.grid, of_heat};
  const Fire fire{.intensity = 2, .colors = {{warm, warm, warm}}};
  v.fire = std::make_shared<const Emitter>(make_emitter(fire, {smoke.grid, of_smoke}, &color, {}));
  const RenderPlan p = plan({&v, 1}, s.scene());
  EXPECT_NE(p.emission->at_collisions.front(), nullptr);
  EXPECT_TRUE(p.emission->lines.sources.empty());
}

/// A spark of one voxel in thin, cold smoke is brighter there than collisions may be.
TEST(Fire, SparksInColdSmokeAreLeftToLines) {
  const Field smoke = make_field("smoke", {0, 0, 0}, {8, 8, 8}, [](Vec3i) { return 0.001; });
  const Field flames = make_field("flames", {0, 0, 0}, {8, 8, 8}, [](Vec3i) { return 1.0; });
  const CloudScene s = cloud_scene();
  const Pyramid of_flames = build_pyramid(flames.grid);
  const Ramp warm{{{0.5f, 0}, {1, 1}}, false};
  for (const Vec3i spark : {Vec3i(4, 4, 4), Vec3i(3, 5, 5)}) {
    const Field heat =
        make_field("heat", {0, 0, 0}, {8, 8, 8}, [&](Vec3i at) { return at == spark ? 1.0 : 0.1; });
    const Pyramid of_heat = build_pyramid(heat.grid);
    const BoundedGrid color{heat.grid, of_heat};
    Volume v = make_volume(smoke.grid, build_pyramid(smoke.grid), s);
    v.fire = std::make_shared<const Emitter>(
        make_emitter({.colors = {{warm, warm, warm}}}, {flames.grid, of_flames}, &color, {}));
    const double brightest = 1 / (0.001 * s.medium.extinction);
    EXPECT_FALSE(detail::FireAtCollisions(v, 0.01 * brightest).lines().empty()) << spark.x;
    EXPECT_TRUE(detail::FireAtCollisions(v, 100 * brightest).lines().empty());
  }
}

/// Each in its own smoke, as if each had a copy.
TEST(Fire, OfTwoVolumesMayBeShared) {
  CloudScene s = cloud_scene();
  s.options.samples = 4;
  std::vector<Volume> volumes;
  for (const double extinction : {0.3, 2.0}) {
    s.medium.extinction = extinction;
    volumes.push_back(make_volume(cloud().grid, build_pyramid(cloud().grid), s));
    volumes.back().fire = fire_of(cloud(), {.intensity = 0.2});
  }
  const Film own = render(volumes, s).film;
  volumes[1].fire = volumes[0].fire;
  EXPECT_TRUE(same_bytes(render(volumes, s).film, own));
}

/// A fire of which one part burns in smoke, one in thin air and one in none at all, as a scene of
/// some kind has it.
struct PartlySmoking {
  CloudScene scene = cloud_scene();
  Rgb extinction_color{1.0f};
  std::vector<Affine> places{};

  [[nodiscard]] Volume volume() const {
    const Field density = make_field("density", {0, 0, 0}, {24, 16, 16}, [](Vec3i at) {
      return at.x < 8 ? 0.0 : at.x < 16 ? 0.002 : 1.0;
    });
    const Field flames = make_field("flames", {0, 0, 0}, {24, 16, 16},
                                    [](Vec3i at) { return 0.2 + 0.1 * (at.y % 3) + 0.02 * at.z; });
    Medium medium = scene.medium.medium();
    medium.extinction_color = extinction_color;
    Volume v = pvol::make_volume(density.grid, build_pyramid(density.grid), medium,
                                 scene.volume_options());
    v.further_places = places;
    v.fire = fire_of(flames, {.intensity = 0.7, .color = Rgb(3.0f, 2.0f, 1.0f)});
    return v;
  }
};

std::vector<std::pair<std::string, PartlySmoking>> partly_smoking() {
  PartlySmoking plain;
  plain.scene.camera.position = {12, 30, 60};
  plain.scene.camera.target = {12, 8, 8};
  plain.scene.medium.extinction = 0.4;
  plain.scene.medium.albedo = Rgb(0.8f, 0.6f, 0.4f);
  plain.scene.options.guide = GuideUse::off;
  PartlySmoking by_channel = plain, placed = plain, grounded = plain, walled = plain,
                guided = plain;
  by_channel.extinction_color = Rgb(0.3f, 1.0f, 0.6f);
  placed.places = {translation({0, 9, 0}) * scaling(Vec3d(0.5))};
  grounded.scene.surfaces = {PlaneSurface{{0, -2, 0}, {0, 1, 0}, {Rgb(0.5f)}}};
  const Material white{Rgb(0.8f)};
  walled.scene.surfaces = {PlaneSurface{{0, -2, 0}, {0, 1, 0}, white},
                           PlaneSurface{{0, 0, -4}, {0, 0, 1}, white},
                           PlaneSurface{{-6, 0, 0}, {1, 0, 0}, white}};
  guided.scene.options.guide = GuideUse::on;
  return {{"plain", plain},
          {"by channel", by_channel},
          {"at two places", placed},
          {"over a ground", grounded},
          {"between white walls", walled},
          {"guided", guided}};
}

/// Whether paths are asked to collide, to walk along lines, or what the plan makes of both.
TEST(Fire, IsTheSameAtCollisionsAndAlongFlights) {
  proof::Family family;
  for (const auto& named : partly_smoking()) {
    const std::string& name = named.first;
    PartlySmoking of = named.second;
    CloudScene s = of.scene;
    const auto picture = [&](LineEmission lines, std::uint64_t seed) {
      // What comes along lines has a twentieth of the noise of what is met at collisions.
      const int parts = lines == LineEmission::off ? 4 : 32;
      s.options.samples = std::uint32_t(proof::samples(name == "plain" ? 30'000 : 3000, parts));
      s.options.line_emission = lines;
      s.options.seed = proof::seeded(seed);
      const Volume v = of.volume();
      const RenderPlan p = plan({&v, 1}, s.scene());
      const bool collides = p.emission->at_collisions.front() != nullptr;
      EXPECT_EQ(collides, lines != LineEmission::on);
      EXPECT_FALSE(p.emission->lines.sources.empty()) << "where there is no density";
      return render(p).film;
    };
    const Film along = picture(LineEmission::on, 21);
    compare(picture(LineEmission::off, 22), along, name + ", at collisions", family);
    compare(picture(LineEmission::automatic, 23), along, name + ", by plan", family);
  }
  EXPECT_TRUE(family.passes());
}

/// Points of lines are looked up in lanes, spread over the whole line, or segment by segment.
TEST(Fire, IsTheSameInLanesAndSegmentBySegment) {
  proof::Family family;
  for (const LineEmission lines : {LineEmission::on, LineEmission::automatic}) {
    for (const auto& named : partly_smoking()) {
      PartlySmoking of = named.second;
      of.scene.options.line_emission = lines;
      of.scene.options.samples = std::uint32_t(proof::samples(2000, 32));
      const auto picture = [&](bool in_lanes, std::uint64_t seed) {
        of.scene.options.seed = proof::seeded(seed);
        Volume v = of.volume();
        if (!in_lanes) v.fire = without_lanes(*v.fire);
        return render({&v, 1}, of.scene).film;
      };
      compare(picture(true, 24), picture(false, 25), named.first, family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Sampled as a light or found by scattered rays.
TEST(Fire, IsTheSameWithoutSamplesOfIt) {
  proof::Family family;
  for (const auto& named : partly_smoking()) {
    const std::string& name = named.first;
    PartlySmoking of = named.second;
    CloudScene s = of.scene;
    s.options.samples = proof::samples(1200);
    const auto picture = [&](bool sampled, std::uint64_t seed) {
      s.options.seed = proof::seeded(seed);
      const Volume v = of.volume();
      RenderPlan p = plan({&v, 1}, s.scene());
      auto emission = std::make_shared<detail::EmissionSetup>(*p.emission);
      emission->sampled_in_volumes = sampled;
      emission->sampled_on_surfaces = sampled;
      p.emission = std::move(emission);
      return render(p).film;
    };
    compare(picture(true, 31), picture(false, 32), name, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Samples cost more than they save within a fire, and pay where smoke is lit by one far away.
TEST(Fire, IsSampledAsALightWhereThatPays) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.0f)};
  s.lights.clear();
  Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  const Fire fire{.intensity = 1};
  v.fire = fire_of(cloud(), fire);
  EXPECT_FALSE(plan({&v, 1}, s.scene()).emission->sampled_in_volumes);
  v.fire = fire_of(cloud(), fire, translation({200, 0, 0}));
  EXPECT_TRUE(plan({&v, 1}, s.scene()).emission->sampled_in_volumes);
}

TEST(Fire, LayersAndOrdersAddUp) {
  CloudScene s = cloud_scene();
  s.options.samples = 16;
  s.options.aovs.add(Aov::lights);
  s.options.aovs.add(Aov::scattering);
  Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  v.fire = fire_of(cloud(), {.intensity = 2}, translation({9, 0, 0}));
  const Film film = render({&v, 1}, s).film;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    Vec3d lights, orders;
    for (const Layer& layer : film.layers) {
      const bool order =
          layer.name == "unscattered" || layer.name == "single" || layer.name == "multiple";
      (order ? orders : lights) += layer.sums[i];
    }
    for (int c = 0; c < 3; ++c) {
      const double sum = film.pixels[i].sum[c];
      EXPECT_NEAR(lights[c], sum, 1e-3 * (1 + sum));
      EXPECT_NEAR(orders[c], sum, 1e-3 * (1 + sum));
    }
  }
}

TEST(Fire, HasNoDepths) {
  CloudScene s = cloud_scene();
  s.options.deep = true;
  Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  s.options.line_emission = LineEmission::on;
  EXPECT_TRUE(says(error_of([&] {
                     (void)plan({&v, 1}, s.scene());
                   }),
                   "fire.deep_pictures_consist"));
  s.options.line_emission = LineEmission::automatic;
  EXPECT_EQ(error_of([&] { (void)plan({&v, 1}, s.scene()); }), "");
  v.fire = fire_of(cloud(), {});
  EXPECT_TRUE(says(error_of([&] {
                     (void)plan({&v, 1}, s.scene());
                   }),
                   "fire.deep_pictures_consist"));
}

using detail::EmissionLights;
using detail::EmissionSource;

/// Blobs of the cloud, apart from each other and of two fires, one of them turned and stretched.
struct Lamps {
  std::shared_ptr<const Emitter> a = fire_of(cloud(), {.intensity = 2}), b;
  std::vector<EmissionSource> sources;

  Lamps() {
    const Affine skewed{{Vec3d{0.3, 0.1, 0}, Vec3d{0, 0.5, 0.1}, Vec3d{0, 0, 0.2}}, {30, 5, -4}};
    b = fire_of(cloud(), {.intensity = 9}, skewed);
    for (const auto& e : {a, b}) sources.push_back({.field = &e->field, .fire = e.get()});
  }
};

TEST(EmissionLights, DensitiesAreThoseOfTheirSamples) {
  const Lamps lamps;
  const EmissionLights lights(lamps.sources);
  proof::Family family;
  for (const Vec3d place :
       {Vec3d{0, 0, 0}, Vec3d{3, -5, 2}, Vec3d{25, 0, 0}, Vec3d{30, 5, -4}, Vec3d{-40, 60, 10}}) {
    // The mean of 1 / pdf over samples is the solid angle that they can reach; of a set of
    // directions it is that of the set: counts in bins of cos and azimuth against its integral.
    const int kSamples = 40'000, kAlong = 6, kFine = 24;
    std::vector<std::uint64_t> counts(kAlong * kAlong * 2);
    std::vector<double> expected(counts.size());
    const auto bin = [](Vec3d d) {
      const double u = 0.5 * (1 + d.z), v = std::atan2(d.y, d.x) / (2 * std::numbers::pi) + 0.5;
      const auto at = [](double x, int n) { return std::min(int(x * n), n - 1); };
      return std::size_t(at(u, kAlong) * 2 * kAlong + at(v, 2 * kAlong));
    };
    Rng rng(proof::seeded(7), 3, std::uint64_t(place.x + 100));
    for (int i = 0; i < kSamples; ++i) {
      const auto to = lights.sample(place, 0, rng);
      ASSERT_GT(to.pdf, 0);
      EXPECT_NEAR(length(Vec3d(to.direction)), 1, 1e-6);
      ++counts[bin(Vec3d(to.direction))];
    }
    // Directions of a fine lattice, jittered: an unbiased integral of the density over each bin.
    const int rows = kAlong * kFine, columns = 2 * kAlong * kFine;
    double whole = 0;
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns; ++j) {
        const auto [a, b] = rng.uniform2();
        const double z = 2 * (i + double(a)) / rows - 1;
        const double phi = 2 * std::numbers::pi * ((j + double(b)) / columns - 0.5);
        const double r = std::sqrt(std::max(0.0, 1 - z * z));
        const Vec3d d{r * std::cos(phi), r * std::sin(phi), z};
        const double share = double(lights.pdf(place, Vec3f(d), 0)) * 4 * std::numbers::pi /
                             (double(rows) * columns);
        expected[bin(d)] += share * kSamples;
        whole += share;
      }
    }
    EXPECT_NEAR(whole, 1, 0.02) << "densities integrate to 1";
    for (double& e : expected) e /= whole;
    // Quadrature leaves errors of bins that the fires fill in part; of the rest counts decide.
    double distance = 0;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      distance += std::abs(double(counts[k]) - expected[k]) / kSamples;
    }
    EXPECT_LT(distance, 0.05) << place.x;
  }
}

}  // namespace fire_test
}  // namespace pvol::test
