// Fields of every kind that lane kernels look up: against flights one by one, and against
// themselves.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/math/field_map.h"
#include "pvol/volume/motion.h"
#include "support/lit_scenes.h"
#include "support/recipes.h"
#include "support/traced_picture.h"
#include "support/velocities.h"
#include "support/wavefront_shots.h"
#include "volume/dense_bounds.h"

namespace pvol::test {
namespace wavefront_look_ups_test {

/// Each by the ways to guide the scene of its number.
template <class Guides>
std::vector<Shot> shots_by(const Guides& guides) {
  std::vector<Shot> all;
  const VoxelGrid& grid = puff().grid;
  const auto add = [&](const std::string& name, CloudScene s, const auto& make) {
    for (const GuideUse guide : guides(all.size())) {
      s.options.guide = guide;
      Volume v = make(s);
      s.camera = frame(v.density.world_box, 1);
      all.push_back({name_of(name, guide), s, {std::move(v)}});
    }
  };
  const auto with = [&](const auto& change) {
    return [&, change](const CloudScene& s) {
      VolumeOptions o = s.volume_options();
      change(o);
      const Pyramid pyramid = build_pyramid(grid, s.options.look_up);
      return pvol::make_volume(grid, pyramid, s.medium.medium(), o);
    };
  };
  CloudScene tricubic = sunny();
  tricubic.options.look_up = LookUp::tricubic;
  for (const MicroBoundsUse use : {MicroBoundsUse::none, MicroBoundsUse::automatic}) {
    tricubic.options.micro_bounds = use;
    add(std::string("tricubic, micro-bounds ") + name(use), tricubic, with([](VolumeOptions&) {}));
  }
  const FieldMap ramp{.ramp = {{{0, 0}, {0.2f, 1.5f}, {0.5f, 0}, {1, 0.7f}}, true}};
  CloudScene nearest = sunny();
  nearest.options.look_up = LookUp::nearest;
  for (const CloudScene& s : {sunny(), nearest}) {
    add(std::string("mapped, ") + name(s.options.look_up), s,
        with([&](VolumeOptions& o) { o.map = std::make_shared<const FieldMap>(ramp); }));
    add(std::string("shared, ") + name(s.options.look_up), s,
        with([](VolumeOptions& o) { o.samples = SampleStorage::shared; }));
  }
  CloudScene recipe = sunny();
  recipe.medium.extinction = 8;
  recipe.options.look_up = LookUp::procedural;
  add("recipe", recipe, [](const CloudScene& s) {
    const auto r = std::make_shared<const Recipe>(make_sample());
    return make_volume(r, build_pyramid(*r), s);
  });
  return all;
}

std::vector<Shot> shots(GuideUse first = GuideUse::on) {
  return shots_by([&](std::size_t number) { return guides_in_turn(number, first); });
}

TEST(WavefrontLookUps, HaveTheMeansOfFlightsOneByOne) {
  expect_means_of_flights_one_by_one(shots(), 300);
}
TEST(WavefrontLookUps, OfEveryWidthGiveTheSameBytes) {
  expect_same_at_every_width(shots(GuideUse::off));
}

/// The puff, which moves while the shutter is open.
Volume puff_in_wind(const CloudScene& s, MicroBoundsUse micro_bounds, SampleStorage samples) {
  const VelocityGrid wind =
      make_velocity({-40, -40, -40}, {64, 64, 64}, [](Vec3i p) { return Vec3d(2, 0.1 * p.x, -1); });
  const Pyramid pyramid = build_pyramid(puff().grid);
  VolumeOptions o = s.volume_options();
  o.micro_bounds = micro_bounds, o.samples = samples;
  const Volume still = pvol::make_volume(puff().grid, pyramid, s.medium.medium(), o);
  return make_moving(still, pyramid, puff().grid.index_to_world, {wind, 1, s.camera.shutter}, o);
}

void expect_same_with_shared_samples(KernelKind kernel, const CloudScene& s) {
  std::optional<Film> plain;
  for (const MicroBoundsUse use : {MicroBoundsUse::none, MicroBoundsUse::codes}) {
    for (const SampleStorage samples : {SampleStorage::copied, SampleStorage::shared}) {
      const Volume v = puff_in_wind(s, use, samples);
      EXPECT_EQ(v.density.motion != nullptr, s.camera.shutter.moves());
      EXPECT_EQ(v.density.shares_samples(), samples == SampleStorage::shared);
      const Film film = render_with(kernel, {"", s, {v}}, s);
      if (!plain) plain = film;
      EXPECT_TRUE(same_bytes(*plain, film))
          << name(kernel) << ", " << name(s.options.look_up) << ", " << name(use)
          << (v.density.shares_samples() ? ", shared" : ", copied");
    }
  }
}

/// Lanes read shared samples one by one, copies together, and codes of either spare nearly all
/// look-ups: the decisions are the same. So are the depths of lines to a sun behind the cloud.
TEST(WavefrontLookUps, OfSharedSamplesChangeNoBit) {
  CloudScene still = sunny();
  still.options.samples = 10;
  still.camera = frame(volume_of(still).density.world_box, 1);
  still.lights = {Sun{still.camera.target - still.camera.position, Rgb(3.0f), 20}};
  CloudScene moving = still;
  moving.camera.shutter = {0, 1};
  std::size_t number = 0;
  for (const KernelKind kernel : simd_kernels()) {
    for (CloudScene s : {still, moving}) {
      ++number;
      for (const LookUp look_up : {LookUp::trilinear, LookUp::nearest}) {
        // A kernel does each with the cloud at rest or in motion, the next one the other way.
        if (!proof::has_turn(number + (number - 1) / 2 + (look_up == LookUp::nearest))) continue;
        s.options.look_up = look_up;
        expect_same_with_shared_samples(kernel, s);
      }
    }
  }
}

/// The picture of paths among bounds of cubes of an edge.
Film render_by_cubes(const Shot& shot, const CloudScene& s, int shift) {
  const RenderPlan p = plan(shot.volumes, s.scene(), {.forecast = false});
  auto dense = std::make_shared<std::vector<detail::DenseBounds>>();
  for (const Volume& v : shot.volumes) {
    dense->push_back(detail::make_dense_bounds(v.density, shift));
  }
  return traced_picture(detail::PathSetup(p, Rgb(0.0f), dense), s.options);
}

/// Large cubes hold leaves that are empty, and reach beyond the support: nothing is there.
TEST(WavefrontLookUps, CubesOfEveryEdgeGiveTheSameMeans) {
  const std::vector<KernelKind> kernels = simd_kernels();
  if (kernels.empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  CloudScene plain = sunny();
  plain.options.guide = GuideUse::off;
  plain.camera =
      frame(puff_in_wind(plain, MicroBoundsUse::none, SampleStorage::copied).density.world_box, 1);
  CloudScene windy = plain;
  windy.camera.shutter = {0, 1};
  std::vector<Shot> all{
      {"plain", plain, {puff_in_wind(plain, MicroBoundsUse::codes, SampleStorage::copied)}},
      {"in wind", windy, {puff_in_wind(windy, MicroBoundsUse::none, SampleStorage::shared)}}};
  const auto plainly = [](std::size_t) { return std::vector{GuideUse::off}; };
  for (Shot& shot : shots_by(plainly)) all.push_back(std::move(shot));
  proof::Family family;
  for (const Shot& shot : all) {
    CloudScene s = shot.scene;
    s.options.kernel = kernels.back();
    s.options.samples = 50 * proof::samples(8u);
    const Film small = render_by_cubes(shot, s, 3);
    s.options.seed = 2;
    const Film large = render_by_cubes(shot, s, 5);
    compare(small, large, shot.name, family);
    compare(average(large), average(small), shot.name + ", again", family);
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace wavefront_look_ups_test
}  // namespace pvol::test
