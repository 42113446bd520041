// How far surfaces and other volumes are from places in a volume, and that rays which are not in
// the world so far bring the same light.
#include "render/path/free_radii.h"

#include <gtest/gtest.h>

#include "pvol/math/moving_map.h"
#include "pvol/render/placement.h"
#include "pvol/volume/facts.h"
#include "render/path/path_setup.h"
#include "render/scene/boxes.h"
#include "support/meshes.h"
#include "support/moving_places.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace free_radii_test {

/// A ground, at a height, and a mesh that moves to the side while the shutter is open.
PlaneSurface ground(double height) { return {{0, height, 0}, {0.1, 1, 0}, {Rgb(0.5f)}}; }
MeshSurface moving_mesh() {
  MeshSurface m = mesh_surface(square_mesh(1), translation({90, 0, 0}));
  m.to = m.place;
  m.to->matrix = translation({120, 0, 0});
  return m;
}

/// Of each place of the cloud: '1' where radii are endless, 'r' where they are not, '0' where none
/// are known.
std::string kinds_of(CloudScene s, const std::vector<Affine>& places = {{}}) {
  VolumeOptions o = s.volume_options();
  o.instances = places;
  const Volume v =
      pvol::make_volume(cloud().grid, build_pyramid(cloud().grid), s.medium.medium(), o);
  const detail::PathSetup setup(plan({&v, 1}, s.scene()));
  std::string all;
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    const bool known = setup.free_radii.known(i);
    all += !known ? '0' : setup.free_radii.of(i).is_endless() ? '1' : 'r';
  }
  return all;
}

TEST(FreeRadii, AreEndlessWhereNoSurfaceReaches) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  const auto among = [&](const std::vector<Surface>& surfaces) {
    CloudScene own = s;
    own.surfaces = surfaces;
    return kinds_of(own);
  };
  EXPECT_EQ(among({}), "1");
  EXPECT_EQ(among({ground(-20)}), "1");
  EXPECT_EQ(among({ground(-5)}), "r");
  EXPECT_EQ(among({ground(-20), ground(9)}), "r");
  EXPECT_EQ(among({ground(-11), ground(-8), ground(-5), ground(-2), ground(1), ground(4), ground(7),
                   ground(10)}),
            "0")
      << "nowhere far enough away";
  EXPECT_EQ(among({BallSurface{{0, 0, 40}, 25, {Rgb(0.5f)}}}), "1");
  EXPECT_EQ(among({BallSurface{{0, 0, 40}, 35, {Rgb(0.5f)}}}), "r");
  EXPECT_EQ(among({BallSurface{{0, 0, 0}, 0.1, {Rgb(0.5f)}}}), "r") << "within";
  // In a room whose walls are far away, and with a table in it.
  const Surface room = mesh_surface(ball_mesh(16), scaling(Vec3d(200)));
  EXPECT_EQ(among({room}), "1");
  EXPECT_EQ(among({room, mesh_surface(square_mesh(60), translation({0, -30, 0}))}), "1");
  EXPECT_EQ(among({room, mesh_surface(square_mesh(60), translation({0, -3, 0}))}), "r");
  EXPECT_EQ(among({room, mesh_surface(square_mesh(0.1), translation({6, -3, 2}))}), "r");
}

TEST(FreeRadii, AreEndlessWhereNoOtherInstanceReaches) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  const auto at = [](double x, double y) { return translation({x, y, 0}); };
  EXPECT_EQ(kinds_of(s, {at(0, 0), at(30, 0), at(0, 30)}), "111");
  EXPECT_EQ(kinds_of(s, {at(0, 0), at(30, 0), at(15, 10)}), "rrr");
  EXPECT_EQ(kinds_of(s, {at(0, 0), at(30, 0), at(-8, 8), at(30, 70)}), "r1r1");
}

/// More clouds in a haze than it can go through: each of them knows the haze.
TEST(FreeRadii, AreEndlessInThinHazeAroundManyClouds) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  CloudScene thin = s;
  thin.medium.extinction = 1e-3;
  VolumeOptions o = s.volume_options(), around = thin.volume_options();
  around.instances = {scaling(Vec3d(100))};
  o.instances.clear();
  for (int i = 0; i < 1100; ++i) {
    o.instances.push_back(translation({30.0 * (i % 11), 30.0 * (i / 11 % 10), 30.0 * (i / 110)}));
  }
  const Pyramid pyramid = build_pyramid(cloud().grid);
  const Volume volumes[] = {pvol::make_volume(cloud().grid, pyramid, s.medium.medium(), o),
                            pvol::make_volume(cloud().grid, pyramid, thin.medium.medium(), around)};
  const detail::PathSetup setup(plan(volumes, s.scene()));
  for (std::uint32_t i = 0; i < 1100; ++i) {
    ASSERT_TRUE(setup.free_radii.known(i)) << i;
    ASSERT_TRUE(setup.free_radii.of(i).is_endless()) << i;
    ASSERT_EQ(setup.free_radii.of(i).thin_ones, 1u) << i;
  }
  EXPECT_FALSE(setup.free_radii.known(1100));
}

TEST(FreeRadii, AreKnownWhereLanesServeAndNothingMoves) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.surfaces = {ground(-20)};
  s.camera.shutter = {0, 1};
  EXPECT_EQ(kinds_of(s), "1");
  s.surfaces.push_back(moving_mesh());
  EXPECT_EQ(kinds_of(s), "0") << "it may come near";
  s.surfaces.pop_back();
  s.options.kernel = KernelKind::scalar;
  EXPECT_EQ(kinds_of(s), "0");
}

/// A radius is not above the distance to any surface and to the box of any other place, and not far
/// below it either.
TEST(FreeRadii, AreDistancesToAllElse) {
  CloudScene s = cloud_scene();
  s.medium.extinction = 10;  // no radius is too small
  const Vec3d ball(-8, 9, 4), card(7, 0, -6);
  s.surfaces = {ground(-7), BallSurface{ball, 3, {Rgb(0.5f)}},
                mesh_surface(square_mesh(4), translation(card))};
  VolumeOptions o = s.volume_options();
  const Affine turned =
      translation({2, 1, 0}) * rotation_about(normalize(Vec3d(1, 2, 3)), 0.7) * scaling(Vec3d(0.9));
  o.instances = {turned, translation({0, 0, 20})};
  const Volume v =
      pvol::make_volume(cloud().grid, build_pyramid(cloud().grid), s.medium.medium(), o);
  const detail::PathSetup setup(plan({&v, 1}, s.scene()));
  const Box support = v.density.octree.support();
  Box other;  // of the cloud at its second place
  for (unsigned k = 0; k < 8; ++k) {
    other = extend(other, setup.free_radii.of(1).to_world.point(corner(support, k)));
  }
  const Vec3d normal = normalize(Vec3d(0.1, 1, 0));
  Rng rng(7, 0, 0);
  double sum = 0, of_distances = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto [x, y, z, w] = rng.uniform4();
    const Vec3d cells = support.lo + support.extent() * Vec3d(double(x), double(y), double(z));
    const double radius =
        double(setup.free_radii.at(0, Vec3f(cells + Vec3d(detail::DenseBounds::kBorder))));
    const Vec3d p = setup.free_radii.of(0).to_world.point(cells);
    const Vec3d on_card(std::clamp(p.x, card.x - 4, card.x + 4), card.y,
                        std::clamp(p.z, card.z - 4, card.z + 4));
    const double distance =
        std::min({std::abs(dot(p - Vec3d(0, -7, 0), normal)), std::abs(length(p - ball) - 3),
                  length(p - on_card), detail::distance(other, p)});
    ASSERT_LE(radius, distance);
    sum += radius, of_distances += distance;
  }
  EXPECT_GT(sum, 0.5 * of_distances);
}

/// Flights in lanes end where their cubes do, a little beyond the cloud's box: a black floor there
/// takes the light from below, and a cloud there that of the first one, however near they lie.
TEST(FreeRadii, LoseNothingOfWhatLiesJustBeyondTheBox) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 90;
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.medium.extinction = 0.1;
  s.lights.clear();
  s.environment = ConstantSky{Rgb(1.0f)};
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  const Box box = world_box({&v, 1});
  for (const double beyond : {0.2, 0.7, 1.5, 3.0, 5.0, 9.0}) {
    s.surfaces = {PlaneSurface{{0, box.lo.y - beyond, 0}, {0, 1, 0}, {Rgb(0.0f)}}};
    const auto picture = [&](KernelKind kernel) {
      CloudScene own = s;
      own.options.kernel = kernel;
      own.options.samples = proof::samples(6000);
      own.options.seed = ++seed;
      return run(cloud(), own).film;
    };
    const Film lanes = picture(KernelKind::automatic), scalar = picture(KernelKind::scalar);
    const std::string name = std::to_string(beyond) + " beyond";
    compare(lanes, scalar, name, family);
    all.add(compare(average(lanes), average(scalar), name + ", again", family));
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// A small black ball in a corner of the cloud's box, where there is no cloud, is all that is
/// different.
TEST(FreeRadii, BringTheSameLight) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 1;
  CloudScene plain = cloud_scene();
  plain.surfaces = {ground(-18)};
  plain.environment = ConstantSky{Rgb(0.4f)};
  CloudScene lamps = plain;
  lamps.lights = {PointLight{{4, 22, 6}, Rgb(900.0f), "", 2}, Sun{{0.6, 0.8, 0.35}, Rgb(1.0f), 3},
                  AreaLight{{0, 30, 0}, {0, -1, 0}, {12, 12}, {0, 0, 1}, Rgb(4.0f), ""}};
  lamps.medium.emission = Rgb(0.3f, 0.1f, 0.02f);
  CloudScene weighted = plain;
  weighted.options.transmittance = Transmittance::ratio;
  for (const auto& [name, scene] : {std::pair<std::string, CloudScene>{"sun and sky", plain},
                                    {"lamps and a glow", lamps},
                                    {"shadow rays with weights", weighted}}) {
    for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
      CloudScene s = scene;
      s.options.guide = guide;
      s.options.samples = proof::samples(800);
      s.options.seed = ++seed;
      EXPECT_EQ(kinds_of(s), "1") << name;
      const Film alone = run(cloud(), s).film;
      s.surfaces.push_back(BallSurface{{9.7, 9.7, -9.7}, 1e-3, {Rgb(0.0f)}});
      EXPECT_EQ(kinds_of(s), "r") << name;
      s.options.seed = ++seed;
      const Film reached = run(cloud(), s).film;
      compare(alone, reached, name, family);
      all.add(compare(average(alone), average(reached), name + ", again", family));
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// What reaches into the cloud's box is met all the same: a floor and a card in it, a second cloud.
TEST(FreeRadii, BringTheLightOfFlightsOneByOne) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 200;
  const auto add = [&](const std::string& name, CloudScene s, const std::vector<Affine>& places) {
    VolumeOptions o = s.volume_options();
    o.instances = places;
    EXPECT_EQ(kinds_of(s, places).find('0'), std::string::npos) << name;
    const auto picture = [&](KernelKind kernel, std::uint32_t samples) {
      s.options.kernel = kernel;
      s.options.samples = proof::samples(samples);
      s.options.seed = ++seed;
      const Volume v =
          pvol::make_volume(cloud().grid, build_pyramid(cloud().grid), s.medium.medium(), o);
      return render(v, s).film;
    };
    const Film lanes = picture(KernelKind::automatic, 1200);
    const Film scalar = picture(KernelKind::scalar, 1200);
    compare(lanes, scalar, name, family);
    all.add(compare(average(lanes), average(scalar), name + ", again", family));
  };
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.environment = ConstantSky{Rgb(0.4f)};
  s.medium.extinction = 2;
  CloudScene floor = s;
  floor.surfaces = {ground(-6), mesh_surface(square_mesh(6), translation({3, 2, -5}))};
  add("floor and card", floor, {{}});
  floor.options.guide = GuideUse::on;
  add("floor and card, guided", floor, {{}});
  floor.options.transmittance = Transmittance::ratio;
  add("floor and card, shadow rays with weights", floor, {{}});
  CloudScene lit = floor;
  lit.medium.emission = Rgb(0.3f, 0.1f, 0.02f);
  lit.lights = {PointLight{{4, 12, 6}, Rgb(900.0f), "", 2}};
  add("floor and card, a lamp and a glow", lit, {{}});
  const Affine turned =
      translation({9, 6, 2}) * rotation_about(normalize(Vec3d(1, 2, 3)), 0.7) * scaling(Vec3d(0.7));
  add("two clouds", s, {{}, turned});
  s.options.guide = GuideUse::on;
  add("two clouds, guided", s, {{}, turned});
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// A dense cloud in two thin absorbing ones.
struct InThinSmoke {
  CloudScene scene;
  std::vector<Volume> volumes;
};

InThinSmoke in_thin_smoke() {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.4f)};
  s.medium.extinction = 12;
  s.medium.albedo = Rgb(0.999f);
  s.medium.g = 0;
  CloudScene thin = s;
  thin.medium.extinction = 0.4;
  thin.medium.albedo = Rgb(0.2f, 0.5f, 0.0f);
  VolumeOptions turned = thin.volume_options();
  turned.instances = {translation({4, 3, 2}) * rotation_about(normalize(Vec3d(1, 2, 3)), 0.7)};
  const auto make = [&](const CloudScene& of, const VolumeOptions& o) {
    return pvol::make_volume(cloud().grid, build_pyramid(cloud().grid), of.medium.medium(), o);
  };
  CloudScene other = thin;
  other.medium.extinction = 0.7;
  other.medium.albedo = Rgb(0.8f, 0.0f, 0.3f);
  VolumeOptions large = other.volume_options();
  large.instances = {translation({0, -9, 3}) * scaling(Vec3d(1.5))};
  return {s, {make(s, s.volume_options()), make(thin, turned), make(other, large)}};
}

/// Of the long ways of the dense cloud's light the thin ones take a part which collisions in them
/// alone find.
TEST(FreeRadii, FindCollisionsInThinVolumes) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 300;
  auto [s, volumes] = in_thin_smoke();
  const auto add = [&, &volumes = volumes](const std::string& name, CloudScene scene) {
    const detail::PathSetup setup(plan(volumes, scene.scene()));
    EXPECT_TRUE(setup.free_radii.known(0)) << name;
    EXPECT_EQ(setup.free_radii.of(0).thin_ones, 2u) << name;
    const auto picture = [&](KernelKind kernel, std::span<const Volume> some) {
      scene.options.kernel = kernel;
      scene.options.samples = proof::samples(1200);
      scene.options.seed = ++seed;
      return render(some, scene).film;
    };
    const Film lanes = picture(KernelKind::automatic, volumes);
    const Film scalar = picture(KernelKind::scalar, volumes);
    compare(lanes, scalar, name, family);
    all.add(compare(average(lanes), average(scalar), name + ", again", family));
    const Film alone = picture(KernelKind::automatic, {volumes.data(), 1});
    EXPECT_LT(average(lanes).mean.z, 0.9 * average(alone).mean.z) << name;
  };
  s.options.guide = GuideUse::off;
  add("in thin smoke", s);
  s.options.guide = GuideUse::on;
  add("in thin smoke, guided", s);
  s.surfaces = {ground(-6)};
  add("in thin smoke on a floor, guided", s);
  s.options.transmittance = Transmittance::ratio;
  s.options.guide = GuideUse::off;
  add("in thin smoke on a floor, shadow rays with weights", s);
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Counts are of the picture's samples alone, not of the photons that lead them, and change none.
TEST(FreeRadii, CountWhatThinVolumesTake) {
  auto [s, volumes] = in_thin_smoke();
  s.options.samples = 8;
  for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
    s.options.guide = guide;
    s.options.count = false;
    const RenderResult plain = render(volumes, s);
    s.options.count = true;
    const RenderResult counted = render(volumes, s);
    EXPECT_TRUE(same_bytes(plain.film, counted.film));
    std::uint64_t look_ups = 0;
    for (std::size_t i = 0; i < counted.film.pixels.size(); ++i) {
      look_ups += counted.film.count(i, PixelCounter::lookups);
    }
    EXPECT_GT(look_ups, 0u);
    EXPECT_EQ(look_ups, counted.counts.path.lookups + counted.counts.shadow.lookups);
  }
}

}  // namespace free_radii_test
}  // namespace pvol::test
