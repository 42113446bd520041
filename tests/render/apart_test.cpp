// Volumes that nothing else reaches: which ones these are, and that rays which stay in them bring
// the same light.
#include "render/path/apart.h"

#include <gtest/gtest.h>

#include "pvol/render/placement.h"
#include "pvol/volume/facts.h"
#include "render/path/path_setup.h"
#include "support/meshes.h"
#include "support/moving_places.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace apart_test {

MeshSurface mesh_surface(TriangleMesh mesh, const Affine& place) {
  MeshSurface m;
  m.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  m.place.matrix = place;
  return m;
}

/// A ground, at a height, and a mesh that moves to the side while the shutter is open.
PlaneSurface ground(double height) { return {{0, height, 0}, {0.1, 1, 0}, {Rgb(0.5f)}}; }
MeshSurface moving_mesh() {
  MeshSurface m = mesh_surface(square_mesh(1), translation({90, 0, 0}));
  m.to = m.place;
  m.to->matrix = translation({120, 0, 0});
  return m;
}

/// Which places of the cloud are apart, as digits.
std::string apart(CloudScene s, const std::vector<Affine>& places = {{}}) {
  VolumeOptions o = s.volume_options();
  o.instances = places;
  const Volume v =
      pvol::make_volume(cloud().grid, build_pyramid(cloud().grid), s.medium.medium(), o);
  const detail::PathSetup setup(plan({&v, 1}, s.scene()));
  std::string all;
  for (std::uint32_t i = 0; i < places.size(); ++i) all += setup.apart.hold(i) ? '1' : '0';
  return all;
}

TEST(Apart, AreThoseThatNoSurfaceReaches) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  const auto among = [&](const std::vector<Surface>& surfaces) {
    CloudScene own = s;
    own.surfaces = surfaces;
    return apart(own);
  };
  EXPECT_EQ(among({}), "1");
  EXPECT_EQ(among({ground(-20)}), "1");
  EXPECT_EQ(among({ground(-5)}), "0");
  EXPECT_EQ(among({ground(-20), ground(9)}), "0");
  EXPECT_EQ(among({BallSurface{{0, 0, 40}, 25, {Rgb(0.5f)}}}), "1");
  EXPECT_EQ(among({BallSurface{{0, 0, 40}, 35, {Rgb(0.5f)}}}), "0");
  EXPECT_EQ(among({BallSurface{{0, 0, 0}, 0.1, {Rgb(0.5f)}}}), "0") << "within";
  // In a room whose walls are far away, and with a table in it.
  const Surface room = mesh_surface(ball_mesh(16), scaling(Vec3d(200)));
  EXPECT_EQ(among({room}), "1");
  EXPECT_EQ(among({room, mesh_surface(square_mesh(60), translation({0, -30, 0}))}), "1");
  EXPECT_EQ(among({room, mesh_surface(square_mesh(60), translation({0, -3, 0}))}), "0");
  EXPECT_EQ(among({room, mesh_surface(square_mesh(0.1), translation({6, -3, 2}))}), "0");
}

TEST(Apart, AreThoseThatNoOtherInstanceReaches) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  const auto at = [](double x, double y) { return translation({x, y, 0}); };
  EXPECT_EQ(apart(s, {at(0, 0), at(30, 0), at(0, 30)}), "111");
  EXPECT_EQ(apart(s, {at(0, 0), at(30, 0), at(15, 10)}), "000");
  EXPECT_EQ(apart(s, {at(0, 0), at(30, 0), at(-8, 8), at(30, 70)}), "0101");
}

TEST(Apart, AreThoseThatLanesServeWhereNothingMoves) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;
  s.surfaces = {ground(-20)};
  s.camera.shutter = {0, 1};
  EXPECT_EQ(apart(s), "1");
  s.surfaces.push_back(moving_mesh());
  EXPECT_EQ(apart(s), "0") << "it may come near";
  s.surfaces.pop_back();
  s.options.kernel = KernelKind::scalar;
  EXPECT_EQ(apart(s), "0");
}

/// Flights in lanes end where their cubes do, a little beyond the cloud's box: a black floor there
/// takes the light from below, and a cloud there that of the first one, however near they lie.
TEST(Apart, LoseNothingOfWhatLiesJustBeyondTheBox) {
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
TEST(Apart, BringTheSameLight) {
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
      EXPECT_EQ(apart(s), "1") << name;
      const Film alone = run(cloud(), s).film;
      s.surfaces.push_back(BallSurface{{9.7, 9.7, -9.7}, 1e-3, {Rgb(0.0f)}});
      EXPECT_EQ(apart(s), "0") << name;
      s.options.seed = ++seed;
      const Film reached = run(cloud(), s).film;
      compare(alone, reached, name, family);
      all.add(compare(average(alone), average(reached), name + ", again", family));
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

}  // namespace apart_test
}  // namespace pvol::test
