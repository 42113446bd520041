// Paths guided by importance: the same picture on average as plain ones, with less noise, from an
// importance that is what closed forms say.
#include "render/guide/importance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/render/guide_choice.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/lit_scenes.h"

namespace pvol::test {
namespace importance_test {

TEST(Importance, GuidedPathsKeepTheMean) {
  proof::Family family;
  proof::Moments all;
  for (Case& c : cases()) {
    c.scene.options.samples = proof::samples(200);
    const Volume v = volume_of(c.scene);
    const RenderResult guided = render(v, c.scene);
    EXPECT_TRUE(guided.guided) << c.name;
    c.scene.options.guide = GuideUse::off;
    c.scene.options.samples *= 3;
    ++c.scene.options.seed;
    const RenderResult plain = render(v, c.scene);
    EXPECT_FALSE(plain.guided) << c.name;
    compare(guided.film, plain.film, c.name, family);
    all.add(compare(average(guided.film), average(plain.film), c.name, family));
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Of many small pictures, so that a variance that is not known, or without limit, would show.
TEST(Importance, MeansOfManySeedsAgree) {
  CloudScene s = sunny();
  const Volume v = volume_of(s);
  proof::Moments guided, plain;
  s.options.samples = 24;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    s.options.seed = seed;
    s.options.guide = GuideUse::on;
    guided.add(average(render(v, s).film).mean.y);
    s.options.guide = GuideUse::off;
    s.options.seed += 1000;
    plain.add(average(render(v, s).film).mean.y);
  }
  proof::Family family;
  const double deviation = (guided.mean() - plain.mean()) /
                           std::sqrt(guided.variance_of_mean() + plain.variance_of_mean());
  family.add("mean", proof::normal_p_value(deviation));
  EXPECT_TRUE(family.passes());
  EXPECT_LT(guided.variance(), 0.5 * plain.variance());
}

/// Light of radiance 1 from everywhere, in part from a constant sky and in part from two suns that
/// are a hemisphere each, but for a belt between them; a body that absorbs glows as brightly.
struct Furnace {
  double g;
  Rgb albedo;
  float sky;
};

TEST(Importance, WhiteFurnace) {
  proof::Family family;
  proof::Moments all;
  for (const Furnace& f : {Furnace{0, Rgb(1.0f), 0.5f}, Furnace{0.877, Rgb(1.0f), 0},
                           Furnace{0.5, Rgb(0.9f, 0.8f, 0.7f), 0.5f}, Furnace{0.3, Rgb(0.6f), 0}}) {
    constexpr double kDegree = std::numbers::pi / 180;
    CloudScene s = sunny();
    s.options.samples = proof::samples(1200);
    s.medium = component(1, f.albedo, f.g, Rgb(1.0f));
    s.environment = ConstantSky{Rgb(f.sky)};
    const double sine = std::sin(89.95 * kDegree);
    const Rgb irradiance(Vec3d((1 - double(f.sky)) * std::numbers::pi * sine * sine));
    s.lights = {Sun{{0.1, 0.3, 1}, irradiance, 179.9}, Sun{{-0.1, -0.3, -1}, irradiance, 179.9}};
    const RenderResult r = render(volume_of(s), s);
    EXPECT_TRUE(r.guided);
    const double belt = (1 - double(f.sky)) * std::sin(0.05 * kDegree);  // none of it is to be seen
    all.add(compare(average(r.film), {Vec3d(1 - belt / 2), Vec3d(0.0)}, "g " + std::to_string(f.g),
                    family, belt / 2));
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Unstable guiding shows first as a variance that differs from one half of the picture's samples
/// to the other.
TEST(Importance, NoiseIsStableAndLess) {
  for (const double g : {0.0, 0.877}) {
    CloudScene s = sunny();
    s.medium.g = g;
    const Volume v = volume_of(s);
    const auto variance = [&](std::uint64_t seed, GuideUse use) {
      s.options.seed = seed;
      s.options.guide = use;
      double sum = 0;
      for (const PixelSums& p : render(v, s).film.pixels) sum += variance_of_mean(p).y;
      return sum;
    };
    const double first = variance(1, GuideUse::on), second = variance(2, GuideUse::on);
    EXPECT_LT(std::abs(first - second), 0.2 * (first + second) / 2) << g;
    EXPECT_LT(first, (g == 0 ? 0.75 : 0.4) * variance(3, GuideUse::off)) << g;
  }
}

/// Towards a lamp close by, which lies in another direction from each place.
TEST(Importance, NoiseAroundALampIsLess) {
  CloudScene s = sunny();
  s.medium.g = 0.877;
  const Volume v = volume_of(s);
  const Box box = v.density.world_box;
  s.lights = {PointLight{box.centre() + Vec3d(0, 0.7 * box.extent().y, 0), Rgb(30.0f)}};
  s.environment = ConstantSky{Rgb(0.0f)};
  const auto variance = [&](GuideUse use) {
    s.options.guide = use;
    ++s.options.seed;
    double sum = 0;
    for (const PixelSums& p : render(v, s).film.pixels) sum += variance_of_mean(p).y;
    return sum;
  };
  EXPECT_LT(variance(GuideUse::on), 0.1 * variance(GuideUse::off));
}

TEST(Importance, ThreadsAndMicroBoundsChangeNoBit) {
  CloudScene s = sunny();
  s.options.samples = 8;
  const Film reference = render(volume_of(s), s).film;
  for (const int threads : {2, 5}) {
    s.options.threads = threads;
    for (const auto use : {MicroBoundsUse::none, MicroBoundsUse::edge_2, MicroBoundsUse::edge_1,
                           MicroBoundsUse::codes}) {
      s.options.micro_bounds = use;
      for (const bool count : {false, true}) {
        s.options.count = count;
        EXPECT_TRUE(same_bytes(reference, render(volume_of(s), s).film));
      }
    }
  }
}

/// Alpha is decided by the first flight, which is the same.
TEST(Importance, AlphaIsThatOfPlainPaths) {
  CloudScene s = sunny();
  const Volume v = volume_of(s);
  const Film guided = render(v, s).film;
  s.options.guide = GuideUse::off;
  const Film plain = render(v, s).film;
  for (std::size_t i = 0; i < plain.pixels.size(); ++i) {
    EXPECT_EQ(guided.pixels[i].alpha, plain.pixels[i].alpha);
  }
}

TEST(Importance, GuidesWhereItMayAndShould) {
  CloudScene s = sunny();
  s.options.guide = GuideUse::automatic;
  const auto choose = [&](std::size_t copies = 1) {
    const std::vector<Body> media(copies, s.medium);
    const double paths = double(s.options.width) * s.options.height * s.options.samples;
    return choose_guide(make_volumes(puff(), media, s), s.scene(), paths);
  };
  s.options.width = s.options.height = 128;
  s.options.samples = 1;
  EXPECT_TRUE(choose().used) << "a first preview";
  s.options.width = s.options.height = 32;
  s.options.samples = 4;
  EXPECT_FALSE(choose().used) << "too few samples";
  s.options.samples = 2000;
  s.medium.extinction = 2;
  EXPECT_TRUE(choose().used) << choose().reason << choose().scatterings;
  EXPECT_TRUE(choose(2).used);
  s.options.max_bounces = 10;
  EXPECT_FALSE(choose().used) << "bounces are limited";
  s.options.guide = GuideUse::on;
  EXPECT_TRUE(choose().used) << "as wished";
  s.options.max_bounces.reset();
  s.options.tracker = Tracker::weighted_delta;
  EXPECT_TRUE(choose().used) << "weights that are 1";
  s.options.majorant_scale = 0.7;
  EXPECT_THROW((void)choose(), Error) << "weights that grow";
  s.options.guide = GuideUse::automatic;
  EXPECT_FALSE(choose().used);
  s.options.majorant_scale = 1;
  s.options.tracker = Tracker::decomposition;
  EXPECT_TRUE(choose().used);
  const Rgb bright = std::get<Sun>(s.lights.front()).irradiance;
  std::get<Sun>(s.lights.front()).irradiance = Rgb(0.0f);
  EXPECT_FALSE(choose().used) << "a sun without light";
  std::get<Sun>(s.lights.front()).irradiance = bright * 0.01f;
  EXPECT_FALSE(choose().used) << "a sun that the sky outshines";
  s.environment = ConstantSky{Rgb(0.0f)};
  EXPECT_TRUE(choose().used) << "the same sun at night";
  s = sunny();
  s.options.guide = GuideUse::automatic;
  s.options.samples = 2000;
  s.medium.extinction = 2;
  s.lights.clear();
  EXPECT_FALSE(choose().used) << "a smooth sky alone";
  s.medium.emission = Rgb(1.0f);
  EXPECT_TRUE(choose().used) << "light from within";
  s = sunny();
  s.options.guide = GuideUse::automatic;
  s.options.samples = 2000;
  s.medium.extinction = 2;
  s.medium.albedo = Rgb(0.5f);
  EXPECT_FALSE(choose().used) << "short paths";
  s.medium.albedo = Rgb(0.99f);
  EXPECT_TRUE(choose().used);
  s.medium.extinction = 0.02;
  EXPECT_FALSE(choose().used) << "a thin cloud";
}

/// Nothing but the constant, darkness, nothing in view, and no cloud at all.
TEST(Importance, WithoutLightOrCloudPathsArePlain) {
  CloudScene s = sunny();
  s.options.samples = 2;
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  EXPECT_FALSE(render(volume_of(s), s).guided);
  s.environment = ConstantSky{Rgb(0.0f)};
  const Volume v = volume_of(s);
  EXPECT_FALSE(render(v, s).guided);
  const detail::PathSetup dark(plan(std::span(&v, 1), s.scene()));
  EXPECT_EQ(detail::trace_photons(dark, detail::make_coarse_cells(v), 100).power, 0);
  s = sunny();
  s.options.samples = 2;
  s.camera = frame(v.density.world_box, 1);
  s.camera.target = s.camera.position * 2.0 - s.camera.target;
  EXPECT_FALSE(render(v, s).guided);
  const Field none = make_field("none", {0, 0, 0}, {3, 3, 3}, [](Vec3i) { return 0.0; });
  s = sunny();
  s.options.samples = 2;
  s.camera.position = {0, 0, 10};
  EXPECT_FALSE(render(make_volumes(none, std::vector{s.medium}, s).front(), s).guided);
}

/// Single voxels, between the points at which mapped density is looked at.
TEST(Importance, OfSpikesThatAreMissedIsNone) {
  const Field spikes = make_field("spikes", {0, 0, 0}, {40, 40, 40}, [](Vec3i p) {
    return p.x % 8 == 0 && p.y % 8 == 0 && p.z % 8 == 0 ? 1.0 : 0.0;
  });
  CloudScene s = sunny();
  s.options.samples = 2;
  s.lights = {PointLight{{20, 100, 20}, Rgb(9e4f)}};
  VolumeOptions o = s.volume_options();
  FieldMap map;
  map.ramp = {{{0.9f, 0}, {1, 1}}, false};
  o.map = std::make_shared<const FieldMap>(map);
  const Volume v = pvol::make_volume(spikes.grid, build_pyramid(spikes.grid), s.medium.medium(), o);
  ASSERT_EQ(detail::make_coarse_cells(v).count(), 1u);
  s.camera = frame(v.density.world_box, 1);
  EXPECT_FALSE(render(v, s).guided);
}

/// Two bricks far apart: more cubes of 8^3 cells in their box than are kept.
TEST(Importance, OfAWideCloudHasLargerCells) {
  const std::vector<float> ones(kBrickSamples, 1.0f);
  VoxelGrid g;
  for (const int at : {0, 1016}) g.bricks.push_back({Vec3i(at), ones.data()});
  const CloudScene s = sunny();
  const Volume v = make_volume(g, build_pyramid(g), s);
  const detail::CoarseCells cells = detail::make_coarse_cells(v);
  EXPECT_EQ(cells.shift, 5);  // 65^3 cubes of 16^3 cells are too many still
  double mass = 0;
  for (const double m : cells.mass) mass += m;
  EXPECT_NEAR(mass, s.medium.extinction * 2 * kBrickSamples, 1e-3);
}

/// In a thin cube the light of a delta sun arrives undimmed, and photons count its irradiance; the
/// mass of the coarse cells is the cube's.
TEST(Importance, PhotonsCountTheLightOfAThinCube) {
  CloudScene s = sunny();
  s.options.look_up = LookUp::nearest;
  s.medium = component(1e-3, Rgb(0.9f), 0.5);
  const Volume v = make_volumes(cube(), std::vector{s.medium}, s).front();
  s.camera = frame(v.density.world_box, 1);
  const detail::PathSetup setup(plan(std::span(&v, 1), s.scene()), Rgb(0.5f));
  const detail::CoarseCells cells = detail::make_coarse_cells(v);
  double mass = 0, collided = 0, straight = 0, direct = 0;
  for (const double m : cells.mass) mass += m;
  EXPECT_NEAR(mass, 1e-3 * 13 * 13 * 13, 1e-6);
  constexpr int kPhotons = 1'000'000;
  const detail::IncidentLight light = detail::trace_photons(setup, cells, kPhotons);
  for (const auto& row : light.collided) {
    straight += double(row[0]);
    for (const float power : row) collided += double(power);
  }
  for (const float power : light.direct) direct += double(power);
  EXPECT_TRUE(light.axes.is_one());
  EXPECT_GT(dot(light.axes.of(1), Vec3f(normalize(Vec3d(0.6, 0.8, 0.35)))), 1 - 1e-6f);
  // About 0.7 % of the photons collide, so that the relative deviation is 1.2 %; a twentieth of the
  // light is emission's negative part, which adds to `collided`, and light scattered twice is less.
  EXPECT_NEAR(direct / (3 * mass), 1, 0.05);
  EXPECT_GE(straight, direct);
  EXPECT_LT(collided, 1.2 * direct);
}

/// From outside, from so far away that float directions do not tell the cube's corners apart, and
/// from within.
TEST(Importance, PhotonsCountTheLightOfAPoint) {
  constexpr double kExtinction = 0.05;
  for (const Vec3d& place : {Vec3d(20, 3, 9), Vec3d(1e9, -2e9, 3e9), Vec3d(6, 8.34, 7.17)}) {
    CloudScene s = sunny();
    s.options.look_up = LookUp::nearest;
    s.medium = component(kExtinction, Rgb(1.0f), 0.5);
    const double squared_distance = dot(place, place);
    s.lights = {PointLight{place, Rgb(float(squared_distance))}};
    const Volume v = make_volumes(cube(), std::vector{s.medium}, s).front();
    s.camera = frame(v.density.world_box, 1);
    const detail::PathSetup setup(plan(std::span(&v, 1), s.scene()), Rgb(0.5f));
    const detail::CoarseCells cells = detail::make_coarse_cells(v);
    const detail::IncidentLight light = detail::trace_photons(setup, cells, 400'000);
    std::vector<double> expected(cells.count());  // by row, so that directions count as well
    constexpr int kPoints = 100;                  // along each edge
    const double step = 13.0 / kPoints;
    for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
      const Vec3i at(i % kPoints, i / kPoints % kPoints, i / kPoints / kPoints);
      const Vec3d p = Vec3d(-0.5) + (Vec3d(at) + Vec3d(0.5)) * step;
      const double distance = length(place - p);
      const double depth =
          optical_depth(std::vector{s.medium}, {p, (place - p) / distance}, distance);
      const Vec3i cell(v.density.world_to_cells.point(p));
      expected[cells.row(widen(cell))] += kExtinction * step * step * step * std::exp(-depth) *
                                          squared_distance / (distance * distance);
    }
    const auto sum = [](const auto& all) { return std::accumulate(all.begin(), all.end(), 0.0); };
    EXPECT_NEAR(sum(light.direct) / sum(expected), 1, 0.025) << place.x;
    for (std::size_t row = 0; row < expected.size(); ++row) {
      if (expected[row] < 0.05 * sum(expected)) continue;  // few photons
      EXPECT_NEAR(double(light.direct[row]) / expected[row], 1, 0.1) << place.x << ", row " << row;
    }
    for (std::size_t row = 1; row < cells.count(); ++row) {
      const Vec3d at = cells.world_cube(row).centre();
      EXPECT_GT(dot(light.axes.of(row), Vec3f(normalize(place - at))), 1 - 1e-6f) << place.x;
    }
  }
}

/// A lamp in the cloud lies above some places and below others, and shines brighter than the sun
/// only around it.
TEST(Importance, AxesPointToTheStrongestLight) {
  const Vec3d lamp(3, 9.34, 4.17), candle(10, 2.2, 8.3);
  CloudScene s = sunny();
  s.options.look_up = LookUp::nearest;
  s.medium = component(0.05, Rgb(1.0f), 0.5);
  const Vec3d to_sun = normalize(Vec3d(0.6, 0.8, 0.35));
  s.lights = {Sun{to_sun, Rgb(1.0f), 0}, PointLight{lamp, Rgb(9.0f)},
              PointLight{candle, Rgb(6.0f), "", 0.1}};
  const Volume v = make_volumes(cube(), std::vector{s.medium}, s).front();
  s.camera = frame(v.density.world_box, 1);
  const detail::PathSetup setup(plan(std::span(&v, 1), s.scene()));
  const detail::CoarseCells cells = detail::make_coarse_cells(v, 1);
  const detail::LightAxes axes = detail::trace_photons(setup, cells, 10).axes;
  ASSERT_EQ(axes.by_row.size(), cells.count());
  std::array<int, 3> rows{};  // at which the sun, the lamp and the candle are strongest
  for (std::size_t row = 1; row < cells.count(); ++row) {
    const Vec3d at = cells.world_cube(row).centre();
    const Vec3d to_lamp = lamp - at, to_candle = candle - at;
    const double of_lamp = 9 / dot(to_lamp, to_lamp), of_candle = 6 / dot(to_candle, to_candle);
    const std::size_t i = of_lamp > std::max(1.0, of_candle) ? 1 : of_candle > 1 ? 2 : 0;
    if (std::min(dot(to_lamp, to_lamp), dot(to_candle, to_candle)) < 4) continue;  // near a lamp
    const Vec3d expected[] = {to_sun, to_lamp, to_candle};
    EXPECT_GT(dot(axes.of(row), Vec3f(normalize(expected[i]))), 1 - 1e-6f) << row;
    ++rows[i];
  }
  for (const int n : rows) EXPECT_GT(n, 0);
}

/// Paths that no photon foresaw must not vanish: light may still come to them.
TEST(Importance, IsNowhereZero) {
  CloudScene s = sunny();
  s.medium = component(4, Rgb(0.3f), 0.95);  // so thick that no photon reaches most of the cells
  s.environment = ConstantSky{Rgb(0.0f)};
  const Volume v = volume_of(s);
  const detail::PathSetup setup(plan(std::span(&v, 1), s.scene()));
  const auto importance = detail::make_importance(setup);
  ASSERT_TRUE(importance);
  const Vec3i last = vec3(v.density.octree.support_hi) - Vec3i(1);
  for (int i = 0; i < 8 * 8 * 8; ++i) {
    const Vec3i part(i % 8, i / 8 % 8, i / 64);
    const Vec3i cell(last.x * part.x / 7, last.y * part.y / 7, last.z * part.z / 7);
    const detail::Importance::Row& row = importance->row(widen(cell));
    for (float u = 0; u <= 1; u += 0.125f) ASSERT_GT(row.of(u), 0) << i << ", " << u;
  }
}

/// What matters is optical depth: nothing hangs on the unit of length.
TEST(Importance, OfASmallCopyIsTheSame) {
  std::vector<detail::Importance> both;
  for (const double scale : {1.0, 1e-3}) {
    CloudScene s = sunny();
    s.options.look_up = LookUp::nearest;
    s.medium = component(0.5 / scale, Rgb(0.9f), 0.5, {}, scaling(Vec3d(scale)));
    const Volume v = make_volumes(cube(), std::vector{s.medium}, s).front();
    s.camera = frame(v.density.world_box, 1);
    const detail::PathSetup setup(plan(std::span(&v, 1), s.scene()), Rgb(0.5f));
    both.push_back(*detail::make_importance(setup));
  }
  for (int i = 0; i < 8; ++i) {
    const Int4 cell = widen(Vec3i(i >> 2, i >> 1 & 1, i & 1) * 12);
    const detail::Importance::Row &a = both[0].row(cell), &b = both[1].row(cell);
    for (std::size_t k = 0; k < a.at.size(); ++k) EXPECT_NEAR(b.at[k] / a.at[k], 1, 0.1) << i;
    EXPECT_NEAR(*both[1].shadow_importance(b) / *both[0].shadow_importance(a), 1, 0.1) << i;
  }
}

/// There the importance is the phase function about the sun, averaged over nodes.
TEST(Importance, IsThePhaseFunctionInAThinCube) {
  CloudScene s = sunny();
  s.options.look_up = LookUp::nearest;
  s.medium = component(1e-2, Rgb(1.0f), 0.5);
  const Volume v = make_volumes(cube(), std::vector{s.medium}, s).front();
  s.camera = frame(v.density.world_box, 1);
  const detail::PathSetup setup(plan(std::span(&v, 1), s.scene()), Rgb(0.5f));
  const auto importance = detail::make_importance(setup);
  ASSERT_TRUE(importance);
  const detail::Importance::Row& row = importance->row(widen(Vec3i(6, 6, 6)));
  const double scale = double(row.of(0.5f)) / phase(0.5, 0.5);
  for (double u = 0.1; u < 1; u += 0.1) {
    const double cosine = 1 - 2 * u * u;
    EXPECT_NEAR(double(row.of(float(u))) / (scale * phase(0.5, cosine)), 1, 0.25) << u;
  }
  EXPECT_TRUE(row.turns());
}

}  // namespace importance_test
}  // namespace pvol::test
