// What volumes are made of, and several of them in one place: components, emission, overlap.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"

namespace pvol::test {
namespace media_test {

const Rgb kBlack(0.0f);

/// From `from` to the middle of the cube.
OneRay towards_middle(std::vector<Body> bodies, Vec3d from) {
  return {std::move(bodies), from, {6, 6, 6}};
}

/// Three kinds of medium that differ in everything.
Body mixture(double extinction) {
  Body m = component(extinction, Rgb(0.9f, 0.1f, 0.3f), -0.5);
  m.others = {{0.3, Rgb(0.2f, 0.8f, 0.1f), HenyeyGreenstein(0.6), kBlack},
              {0.2, Rgb(0.0f, 0.5f, 1.0f), HenyeyGreenstein(0), kBlack}};
  return m;
}

/// Density that looks different from every side: a ball with a chequered half and a soft end.
double lump(Vec3i p) {
  const Vec3d q(p.x / 11.0, p.y / 8.0, p.z / 9.5);
  const bool hole = (p.x >> 2 ^ p.y >> 2 ^ p.z >> 2) & 1;
  return dot(q, q) > 1 ? 0 : (hole && p.x < 3 ? 0.1 : 1) * (1 - 0.04 * (p.y + 10));
}
const Field& cloud() {
  static const Field f = make_field("lump", {-12, -12, -12}, {25, 25, 25}, lump);
  return f;
}

/// The cloud, optically 5 thick, under a sun and a bright sky.
CloudScene cloud_scene() {
  CloudScene s;
  s.camera.position = {5, 8, 60};
  s.camera.target = {0, 0, 0};
  s.camera.fov = 24;
  s.environment = ConstantSky{Rgb(0.2f, 0.3f, 0.5f)};
  s.medium = component(0.4, Rgb(0.95f, 0.9f, 0.8f), 0.6);
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.options.width = s.options.height = 8;
  s.options.samples = 300;
  s.options.threads = 1;
  return s;
}

Film picture(const std::vector<Body>& media, const CloudScene& s) {
  CloudScene scene = s;
  scene.medium = media.front();
  return render(make_volumes(cloud(), media, scene), scene).film;
}

/// Single scattering is linear in share, albedo and phase function.
TEST(Media, ComponentsScatterInProportionToTheirShares) {
  const Sun suns[] = {Sun{{0.5, 0.7, -0.3}, Rgb(2.0f, 3.0f, 1.5f), 0},
                      Sun{{1, 0.8, 0.6}, Rgb(3.0f), 0}, Sun{{-1, -0.7, -0.8}, Rgb(1.0f), 0}};
  proof::Family family;
  proof::Moments all;
  std::uint64_t number = 0;
  for (const double extinction : {0.05, 0.3}) {
    for (const Tracker tracker : {Tracker::delta, Tracker::decomposition}) {
      for (const Transmittance transmittance : kTransmittances) {
        for (const Sun& sun : suns) {
          OneRay r = towards_middle({mixture(extinction)}, {30, 25, 28});
          r.scene.lights = {sun};
          r.scene.options.samples = proof::samples(60'000);
          r.scene.options.tracker = tracker;
          r.scene.options.transmittance = transmittance;
          r.scene.options.seed = ++number;
          all.add(compare(r, std::string(label(tracker)) + ", " + label(transmittance), family));
        }
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Each glows in a colour of its own; every ray ends in one of them.
TEST(Media, CollisionsFallToComponentsByTheirShares) {
  Body m = component(5, kBlack, 0, Rgb(1.0f, 0.0f, 0.0f));
  m.others = {{0.35, kBlack, HenyeyGreenstein(0), Rgb(0.0f, 1.0f, 0.0f)},
              {0.2, kBlack, HenyeyGreenstein(0), Rgb(0.0f, 0.0f, 1.0f)}};
  OneRay r = towards_middle({m}, {30, 25, 28});
  r.scene.options.samples = proof::samples(1'000'000);
  proof::Family family;
  compare(r, "shares", family);
  EXPECT_TRUE(family.passes());
}

TEST(Media, AComponentInPartsIsOne) {
  const CloudScene s = cloud_scene();
  const Body& whole = s.medium;
  const Film reference = picture({whole}, s);
  proof::Family family;
  std::uint64_t number = 0;
  for (const std::vector<double>& shares : {std::vector{0.3, 0.2}, {1.0}, {0.0}, {0.5, 0.5}}) {
    Body split = whole;
    for (const double share : shares) {
      split.others.push_back({share, whole.albedo, HenyeyGreenstein(whole.g), whole.emission});
    }
    CloudScene other = s;
    other.options.seed = 100 + ++number;
    compare(reference, picture({split}, other), "split " + std::to_string(number), family);
  }
  EXPECT_TRUE(family.passes());
}

/// Where phase functions agree, only the mean albedo counts.
TEST(Media, AbsorbersLowerTheAlbedo) {
  const CloudScene s = cloud_scene();
  Body mixed = component(0.4, Rgb(1.0f, 0.9f, 0.4f), 0.6);
  mixed.others = {{0.25, kBlack, HenyeyGreenstein(0.6), kBlack},
                  {0.25, Rgb(1.0f, 0.2f, 0.8f), HenyeyGreenstein(0.6), kBlack}};
  const Body mean = component(0.4, Rgb(0.75f, 0.5f, 0.4f), 0.6);
  CloudScene other = s;
  other.options.seed = 2;
  proof::Family family;
  compare(picture({mixed}, s), picture({mean}, other), "mean albedo", family);
  EXPECT_TRUE(family.passes());
}

/// L (1 - exp(-tau)) + sky exp(-tau), L the emission of what collides, less what it scatters.
TEST(Media, EmissionFollowsBeerAndLambert) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t number = 0;
  for (const Tracker tracker : kTrackers) {
    for (const double extinction : {1e-3, 0.05, 0.3, 5.0}) {
      for (const Vec3d from : {Vec3d(30, 25, 28), Vec3d(6.5, 7, 3000), Vec3d(3, 4, 9)}) {
        Body m = component(extinction, kBlack, 0, Rgb(2.0f, 0.5f, 0.1f));
        if (number % 2 != 0) {
          m.others = {{0.4, Rgb(0.5f, 0.0f, 1.0f), HenyeyGreenstein(0.3), Rgb(1.0f, 4.0f, 50.0f)}};
        }
        OneRay r = towards_middle({m}, from);
        r.scene.environment = ConstantSky{Rgb(0.3f, 1.0f, 0.1f)};
        r.scene.options.tracker = tracker;
        r.scene.options.seed = ++number;
        // Without scattering, paths end by themselves.
        r.scene.options.max_bounces = 0;
        all.add(compare(
            r, std::string(label(tracker)) + ", extinction " + std::to_string(extinction), family));
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// A medium that is as bright as its surroundings cannot be seen: at albedo 0 in any sample,
/// else on average, roulette being the only noise.
TEST(Media, MatterInThermalEquilibriumIsInvisible) {
  const Rgb glow(0.7f, 0.2f, 3.0f);
  proof::Family family;
  std::uint64_t number = 0;
  for (const Rgb albedo : {Rgb(0.0f), Rgb(0.5f), Rgb(0.99f, 0.2f, 0.7f), Rgb(1.0f)}) {
    for (const double g : {-0.7, 0.0, 0.9}) {
      CloudScene s = cloud_scene();
      s.lights.clear();
      s.environment = ConstantSky{glow};
      Body m = component(0.5, albedo, g, glow);
      if (number % 2 != 0)
        m.others = {{0.3, Rgb(0.1f, 0.9f, 0.6f) * albedo, HenyeyGreenstein(-0.2), glow}};
      s.options.seed = ++number;
      const std::string name = "albedo " + std::to_string(albedo.y) + ", g " + std::to_string(g);
      const Film film = picture({m}, s);
      compare(average(film), {Vec3d(glow), Vec3d(0.0)}, name, family, 1e-6);
      for (const PixelSums& p : film.pixels) {
        if (max_component(albedo) > 0) break;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean(p)[c] / double(glow[c]), 1, 1e-6);
      }
      s.environment = ImageSky{6, 3, std::vector<Rgb>(18, glow), Rgb(1.0f), 20};
      compare(average(picture({m}, s)), {Vec3d(glow), Vec3d(0.0)}, name + ", a picture as sky",
              family, 1e-6);
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(Media, TwoHalvesAreOneWhole) {
  const CloudScene s = cloud_scene();
  const Film whole = picture({s.medium}, s);
  Body half = s.medium;
  half.extinction /= 2;
  proof::Family family;
  std::uint64_t number = 0;
  const Tracker trackers[] = {Tracker::delta_global, Tracker::delta, Tracker::decomposition,
                              Tracker::regular};
  for (const Tracker tracker : trackers) {
    for (const Transmittance transmittance : kTransmittances) {
      if (is_slow(tracker, transmittance) && number % 3 != 0) continue;
      CloudScene other = s;
      other.options.tracker = tracker;
      other.options.transmittance = transmittance;
      other.options.seed = 100 + ++number;
      if (is_slow(tracker, transmittance)) other.options.samples /= 4;
      compare(whole, picture({half, half}, other),
              std::string(label(tracker)) + ", " + label(transmittance), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A quarter turn about z.
Affine quarter_turn() {
  Affine a;
  a.m = {Vec3d(0, -1, 0), Vec3d(1, 0, 0), Vec3d(0, 0, 1)};
  return a;
}

/// A second grid that holds the same cloud, turned, in cells of half the size, but placed back: the
/// volumes' frames differ, the density is the same.
TEST(Media, EachVolumeHasAFrameOfItsOwn) {
  CloudScene s = cloud_scene();
  s.options.look_up = LookUp::nearest;
  const Film whole = picture({s.medium}, s);
  const Affine turn = quarter_turn();
  // Samples of half the size: two for one along each axis, their middles a quarter of a cell aside.
  const Field fine = make_field("turned lump", {-24, -24, -24}, {50, 50, 50}, [&](Vec3i p) {
    const Vec3d at = turn.vector(Vec3d(p.x >> 1, p.y >> 1, p.z >> 1));
    return double(cloud().at({int(at.x), int(at.y), int(at.z)}));
  });
  s.medium.extinction *= 0.3;
  std::vector<Volume> volumes = make_volumes(cloud(), std::vector{s.medium}, s);
  s.medium.extinction *= 0.7 / 0.3;
  s.medium.object_to_world = turn * translation(Vec3d(-0.25)) * scaling(Vec3d(0.5));
  volumes.push_back(make_volumes(fine, std::vector{s.medium}, s).front());
  s.options.seed = 2;
  proof::Family family;
  compare(whole, render(volumes, s).film, "turned", family);
  EXPECT_TRUE(family.passes());
}

/// Turned about the axis (1, 1, 0), stretched and moved; orthonormal before it is stretched.
Affine skew_place(Vec3d stretch, Vec3d to) {
  constexpr double kHalf = 0.5, kRoot = 0.70710678118654752440;
  Affine a;
  a.m = {Vec3d(kHalf, kHalf, kRoot), Vec3d(kHalf, kHalf, -kRoot), Vec3d(-kRoot, kRoot, 0)};
  return translation(to) * a * scaling(stretch) * translation(Vec3d(-6));
}

/// Bodies in all positions to each other, as the camera sees them.
std::vector<std::vector<Body>> arrangements(bool glowing) {
  const auto of = [glowing](double extinction, Rgb colour, double g, const Affine& place) {
    return glowing ? component(extinction, colour * 0.3f, g, Rgb(3.0f) * colour, place)
                   : component(extinction, colour, g, kBlack, place);
  };
  const Rgb red(1.0f, 0.2f, 0.1f), green(0.1f, 0.9f, 0.2f), blue(0.2f, 0.1f, 1.0f);
  const Affine here, behind = translation({-20, -14, -16}), above = translation({4, 14, 1});
  const Affine core = translation({4, 4, 4}) * scaling(Vec3d(0.3));
  const Affine tilted = skew_place({0.7, 1.3, 0.4}, {7, 5, 8});
  return {
      {of(0.1, red, 0, here), of(0.15, green, 0.3, behind)},
      {of(0.08, red, 0.5, here), of(0.5, kBlack, 0, core)},
      {of(0.05, red, 0.5, here), of(0.4, blue, -0.4, core), of(0.1, green, 0, above)},
      {of(0.1, red, 0, here), of(0.2, blue, 0.6, tilted)},
      {of(0.1, red, 0.2, tilted), of(0.07, green, 0, here), of(0.04, blue, 0, scaling({2, 1, 1.1})),
       of(0, red, 0, core)},
  };
}

TEST(Media, BodiesAbsorbAndGlowInTurn) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t number = 0;
  for (std::vector<Body> bodies : arrangements(true)) {
    for (const Tracker tracker :
         {Tracker::delta_global, Tracker::delta, Tracker::decomposition, Tracker::regular}) {
      std::reverse(bodies.begin(), bodies.end());  // the order does not count
      for (const Vec3d from : {Vec3d(30, 25, 28), Vec3d(6.2, 6.1, 5)}) {
        OneRay r = towards_middle(bodies, from);
        r.scene.environment = ConstantSky{Rgb(0.3f, 1.0f, 0.1f)};
        r.scene.options.max_bounces = 0;
        r.scene.options.samples = proof::samples(20'000u);
        r.scene.options.tracker = tracker;
        r.scene.options.seed = ++number;
        all.add(
            compare(r, "arrangement " + std::to_string(number) + ", " + label(tracker), family));
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

TEST(Media, BodiesThrowShadowsOnEachOther) {
  proof::Family family;
  proof::Moments all;
  std::uint64_t number = 0;
  for (std::vector<Body> bodies : arrangements(false)) {
    for (const Transmittance transmittance : kTransmittances) {
      std::reverse(bodies.begin(), bodies.end());
      for (const Vec3d to_sun : {Vec3d(0.1, 1, -0.1), Vec3d(-0.6, -0.5, -0.8)}) {
        OneRay r = towards_middle(bodies, {30, 25, 28});
        r.scene.lights = {Sun{to_sun, Rgb(4.0f), 0}};
        r.scene.options.samples =
            proof::samples(transmittance == Transmittance::regular ? 20'000 : 80'000);
        r.scene.options.transmittance = transmittance;
        r.scene.options.seed = ++number;
        all.add(compare(r, "arrangement " + std::to_string(number) + ", " + label(transmittance),
                        family));
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Two clouds of different media that overlap in part, with all orders of scattering.
TEST(Media, TheOrderOfVolumesDoesNotCount) {
  CloudScene s = cloud_scene();
  s.environment = ImageSky{2, 1, {Rgb(1.0f, 0.2f, 0.3f), Rgb(0.1f, 0.8f, 2.0f)}, Rgb(1.0f), 40};
  const Body a = mixture(0.3), b = component(0.5, Rgb(0.99f), 0.8, kBlack, translation({3, 4, -5}));
  const Film one = picture({a, b}, s);
  s.options.seed = 2;
  proof::Family family;
  compare(one, picture({b, a}, s), "reversed", family);
  EXPECT_TRUE(family.passes());
}

TEST(Media, OverlappingWhiteBodiesAreInvisible) {
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.environment = ConstantSky{Rgb(1.0f)};
  s.options.samples = 50;
  const std::vector<Body> white{
      component(0.3, Rgb(1.0f), 0.9),
      component(0.4, Rgb(1.0f), -0.5, kBlack, skew_place({0.8, 1.2, 1}, {2, 3, 1}))};
  for (const PixelSums& p : picture(white, s).pixels) EXPECT_EQ(mean(p), Vec3d(1.0));
  s.environment = ImageSky{6, 3, std::vector<Rgb>(18, Rgb(1.0f)), Rgb(1.0f), 20};
  s.options.samples = proof::samples(300);
  proof::Family family;
  for (const Transmittance transmittance : kTransmittances) {
    if (transmittance == Transmittance::regular) s.options.samples /= 10;
    s.options.transmittance = transmittance;
    ++s.options.seed;
    compare(average(picture(white, s)), {Vec3d(1.0), Vec3d(0.0)}, label(transmittance), family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(Media, EmptyVolumesTakeNoPart) {
  CloudScene s = cloud_scene();
  const Field none = make_field("none", {0, 0, 0}, {3, 3, 3}, [](Vec3i) { return 0.0; });
  const Volume full = make_volumes(cloud(), std::vector{s.medium}, s).front();
  const Volume empty = make_volumes(none, std::vector{s.medium}, s).front();
  const Film one = render(full, s).film, before = render(std::vector{empty, full}, s).film;
  EXPECT_TRUE(same_bytes(before, render(std::vector{full, empty, empty}, s).film));
  ++s.options.seed;
  proof::Family family;
  compare(one, render(std::vector{full, empty}, s).film, "with an empty volume", family);
  EXPECT_TRUE(family.passes());
  s.environment = ConstantSky{Rgb(0.25f)};
  for (const PixelSums& p : render(std::vector{empty, empty}, s).film.pixels) {
    EXPECT_EQ(mean(p), Vec3d(0.25));
    EXPECT_EQ(p.alpha, 0);
  }
}

TEST(Media, WhatMakesNoSenseIsRefused) {
  CloudScene s = cloud_scene();
  EXPECT_THROW((void)render(std::vector<Volume>{}, s), Error);
  const auto refused = [&](auto change) {
    Body m = s.medium;
    m.others = {{0.5, Rgb(0.5f), HenyeyGreenstein(0), kBlack}};
    change(m);
    EXPECT_THROW((void)picture({m}, s), Error);
    EXPECT_THROW((void)picture({s.medium, m}, s), Error);
  };
  refused([](Body& m) { m.others[0].share = 1.01; });
  refused([](Body& m) { m.others[0].share = -0.01; });
  refused([](Body& m) { m.others[0].share = std::nan(""); });
  refused([](Body& m) { m.others.push_back({0.6, Rgb(0.5f), {}, kBlack}); });
  refused([](Body& m) { m.others[0].albedo.x = 1.5f; });
  refused([](Body& m) { m.others[0].phase = HenyeyGreenstein(-1); });
  refused([](Body& m) { m.others[0].emission.z = -1; });
  refused([](Body& m) { m.emission.y = std::nanf(""); });
}

/// A component of two lobes is two components of one lobe each.
TEST(Media, TwoLobesAreTwoComponents) {
  const CloudScene s = cloud_scene();
  proof::Family family;
  for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
    CloudScene one = s, two = s;
    one.options.guide = two.options.guide = guide;
    two.options.seed = 77;
    const TwoLobes lobes{HenyeyGreenstein(0.8), HenyeyGreenstein(-0.5), 0.75};
    Volume volume = make_volumes(cloud(), std::vector{s.medium}, one).front();
    const Component component = volume.medium.components.front();
    volume.medium.components = {component};
    volume.medium.components[0].phase = lobes;
    const Film lobed = pvol::render(volume, one.scene()).film;
    volume.medium.components = {component, component};
    volume.medium.components[0].share = lobes.share;
    volume.medium.components[0].phase = lobes.forward;
    volume.medium.components[1].share = 1 - lobes.share;
    volume.medium.components[1].phase = lobes.backward;
    compare(lobed, pvol::render(volume, two.scene()).film, name(guide), family);
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace media_test
}  // namespace pvol::test
