// Surfaces among volumes in the lane kernels, and volumes that move there: against the scalar
// tracers, and against themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "pvol/volume/emitter.h"
#include "pvol/volume/motion.h"
#include "support/lit_scenes.h"
#include "support/meshes.h"
#include "support/moving_places.h"
#include "support/velocities.h"
#include "support/wavefront_shots.h"

namespace pvol::test {
namespace wavefront_surfaces_test {

Volume puff_of(const CloudScene& s, const Affine& place = {}) {
  CloudScene at = s;
  at.medium.object_to_world = place;
  return make_volume(puff().grid, build_pyramid(puff().grid), at);
}

Volume with_fire(Volume v) {
  const Pyramid pyramid = build_pyramid(puff().grid);
  v.fire = std::make_shared<const Emitter>(make_emitter(
      {.intensity = 0.1, .color = Rgb(6.0f, 3.0f, 1.0f)}, {puff().grid, pyramid}, nullptr, {}));
  return v;
}

/// The puff, turning about its middle.
Volume whirling(const CloudScene& s) {
  const VelocityGrid velocity = make_velocity({-8, -8, -8}, {48, 40, 44}, [](Vec3i p) {
    return Vec3d(p.y - 16, 20 - p.x, 6 * std::sin(0.4 * p.x)) * (p.z > 18 ? 0.8 : -0.3);
  });
  const Pyramid p = build_pyramid(puff().grid, s.options.look_up);
  return make_moving(make_volume(puff().grid, p, s), p, puff().grid.index_to_world,
                     {velocity, 1, s.camera.shutter}, s.volume_options());
}

Surface floor_of(const Material& material) { return PlaneSurface{{0, -3, 0}, {0, 1, 0}, material}; }
Surface ball_of(const Material& material, Vec3d centre = {34, 8, 30}, double radius = 7) {
  return BallSurface{centre, radius, material};
}
Surface wall_of(const Material& material) {
  MeshSurface m;
  m.mesh = std::make_shared<const TriangleMesh>(ball_mesh(8));
  m.place.matrix = translation({-14, 14, 10}) * scaling({6, 20, 20});
  m.material = material;
  return m;
}

/// A scene by what it has, plain and guided.
struct Shots {
  GuideUse first;
  std::vector<Shot> all{};

  template <class Change>
  void add(const std::string& name, const Change& change) {
    CloudScene s = sunny();
    s.medium.albedo = Rgb(0.99f);
    s.camera = Camera{{120, 60, 90}, {25, 12, 18}};
    s.camera.fov = 34;
    std::vector<Volume> volumes;
    change(s, volumes);
    if (volumes.empty()) volumes.push_back(puff_of(s));
    std::vector<GuideUse> guides = guides_in_turn(all.size(), first);
    if (s.options.max_bounces) guides = {GuideUse::off};
    for (const GuideUse guide : guides) {
      s.options.guide = guide;
      all.push_back({name_of(name, guide), s, volumes});
    }
  }
};

constexpr Visibility kCatcher = Visibility::shadow_catcher, kHoldout = Visibility::holdout;

void add_surfaces(Shots& shots) {
  shots.add("grey ground", [](CloudScene& s, auto&) { s.surfaces = {floor_of({Rgb(0.4f)})}; });
  shots.add("all kinds, coloured, and layers", [](CloudScene& s, auto&) {
    s.surfaces = {floor_of({Rgb(0.5f, 0.3f, 0.2f)}), ball_of({Rgb(0.1f, 0.7f, 0.8f)}),
                  wall_of({Rgb(0.9f, 0.9f, 0.2f)})};
    s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f, 2.0f, 1.0f), 8},
                PointLight{{30, 60, 18}, Rgb(6e3f)}};
    s.environment = GradientSky{};
    s.options.aovs = {Aov::lights, Aov::scattering, Aov::normal, Aov::albedo, Aov::depth};
  });
  shots.add("lamps that are met, by a wall", [](CloudScene& s, auto&) {
    s.surfaces = {floor_of({Rgb(0.5f)}), wall_of({Rgb(0.8f, 0.5f, 0.5f)})};
    s.lights = {PointLight{{30, 36, 40}, Rgb(3e3f), "", 4}, AreaLight{.position = {10, 50, 18},
                                                                      .direction = {0.2, -1, 0},
                                                                      .size = {20, 20},
                                                                      .radiance = Rgb(9.0f)}};
  });
  shots.add("few bounces, and a picture of a sky", [](CloudScene& s, auto&) {
    s.surfaces = {floor_of({Rgb(0.7f)}), ball_of({Rgb(0.7f)})};
    s.environment = ImageSky{2, 2, {Rgb(4.0f), Rgb(0.0f), Rgb(1.0f), Rgb(2.0f)}};
    s.options.max_bounces = 2;
  });
  shots.add("shadow rays by ratio", [](CloudScene& s, auto&) {
    s.surfaces = {floor_of({Rgb(0.7f)})};
    s.options.transmittance = Transmittance::ratio;
  });
}

void add_looks(Shots& shots) {
  shots.add("a catcher", [](CloudScene& s, auto&) {
    s.surfaces = {floor_of({Rgb(0.4f, 0.3f, 0.2f), kCatcher}), ball_of({Rgb(0.7f)})};
    s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f, 2.0f, 1.0f), 20}};
    s.environment = GradientSky{};
    s.options.aovs = {Aov::lights, Aov::scattering};
  });
  shots.add("a catcher, a holdout, a lamp", [](CloudScene& s, auto&) {
    s.surfaces = {floor_of({Rgb(0.5f), kCatcher}), ball_of({Rgb(0.7f), kHoldout})};
    s.lights = {PointLight{{50, 40, 40}, Rgb(4e3f), "", 9}};
    s.options.background = false;
  });
  const auto seen_by = [](bool camera, bool shadow, bool light) {
    return Material{Rgb(0.6f, 0.5f, 0.4f), Visibility::surface, camera, shadow, light};
  };
  shots.add("surfaces that rays pass", [&](CloudScene& s, auto&) {
    s.medium.albedo = Rgb(0.9f);
    s.medium.emission = Rgb(0.5f);
    s.surfaces = {floor_of({Rgb(0.5f)}), ball_of(seen_by(true, false, true)),
                  ball_of(seen_by(false, true, true), {10, 34, 20}, 5),
                  wall_of(seen_by(true, true, false))};
    s.environment = GradientSky{};
  });
}

void add_fires_and_more(Shots& shots) {
  shots.add("a fire", [](CloudScene& s, std::vector<Volume>& volumes) {
    s.medium.albedo = Rgb(0.7f);
    s.surfaces = {floor_of({Rgb(0.5f)}), ball_of({Rgb(0.7f, 0.5f, 0.5f)})};
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights.clear();
    volumes = {with_fire(puff_of(s))};
  });
  shots.add("a fire by a catcher", [](CloudScene& s, std::vector<Volume>& volumes) {
    s.surfaces = {floor_of({Rgb(0.5f), kCatcher}),
                  ball_of({Rgb(0.7f), Visibility::surface, true, false, true})};
    volumes = {with_fire(puff_of(s))};
  });
  shots.add("two volumes", [](CloudScene& s, std::vector<Volume>& volumes) {
    s.surfaces = {floor_of({Rgb(0.5f)}), ball_of({Rgb(0.7f)})};
    volumes = {puff_of(s), puff_of(s, translation({30, 4, -6}) * scaling(Vec3d(0.8)))};
  });
  shots.add("a volume that moves", [](CloudScene& s, std::vector<Volume>& volumes) {
    s.camera.shutter = {-0.5, 0.5};
    volumes = {moving(puff(), s, alone(swinging()))};
  });
  for (const LookUp look_up : {LookUp::nearest, LookUp::trilinear, LookUp::tricubic}) {
    shots.add("velocities, " + std::string(name(look_up)),
              [&](CloudScene& s, std::vector<Volume>& volumes) {
                s.camera.shutter = {-0.5, 0.5};
                s.options.look_up = look_up;
                s.surfaces = {floor_of({Rgb(0.5f)})};
                volumes = {whirling(s)};
              });
  }
  shots.add("volumes that move over ground", [](CloudScene& s, std::vector<Volume>& volumes) {
    s.camera.shutter = {0, 1};
    s.surfaces = {floor_of({Rgb(0.5f)}), ball_of({Rgb(0.7f)})};
    volumes = {moving(puff(), s,
                      {place_of(shifted({0, 0, 0}, {30, 0, 5}), MovingMap{}),
                       place_of(shifted({-20, 5, 20}, {-20, 5, 20}), MovingMap{})})};
  });
}

std::vector<Shot> shots(GuideUse first = GuideUse::on) {
  Shots s{first};
  add_surfaces(s);
  add_looks(s);
  add_fires_and_more(s);
  return std::move(s.all);
}

TEST(WavefrontSurfaces, LeaveTheSceneItsKernel) {
  CloudScene s = sunny();
  const Volume v = puff_of(s);
  const KernelKind without = plan({&v, 1}, s.scene()).kernel.kind;
  s.surfaces = {floor_of({}), ball_of({}), wall_of({})};
  EXPECT_EQ(plan({&v, 1}, s.scene()).kernel.kind, without);
}

TEST(WavefrontSurfaces, HaveTheMeansOfFlightsOneByOne) {
  expect_means_of_flights_one_by_one(shots(), 600);
}
TEST(WavefrontSurfaces, OfEveryWidthGiveTheSameBytes) {
  expect_same_at_every_width(shots(GuideUse::off));
}
TEST(WavefrontSurfaces, CompanyChangesNoBit) { expect_same_in_any_company(shots()); }

}  // namespace wavefront_surfaces_test
}  // namespace pvol::test
