// Fields whose densities the lane kernels look up one by one: against flights one by one, and
// against themselves.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/math/field_map.h"
#include "support/lit_scenes.h"
#include "support/recipes.h"
#include "support/wavefront_shots.h"

namespace pvol::test {
namespace wavefront_look_ups_test {

std::vector<Shot> shots() {
  std::vector<Shot> all;
  const VoxelGrid& grid = puff().grid;
  const auto add = [&](const std::string& name, CloudScene s, const auto& make) {
    for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
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

TEST(WavefrontLookUps, HaveTheMeansOfFlightsOneByOne) {
  expect_means_of_flights_one_by_one(shots(), 300);
}
TEST(WavefrontLookUps, OfEveryWidthGiveTheSameBytes) { expect_same_at_every_width(shots()); }

/// Shared samples are looked up one by one, copied ones in lanes, and codes of either spare nearly
/// all look-ups: the decisions are the same.
TEST(WavefrontLookUps, OfSharedSamplesChangeNoBit) {
  const Pyramid pyramid = build_pyramid(puff().grid);
  for (const KernelKind kernel : simd_kernels()) {
    for (const LookUp look_up : {LookUp::trilinear, LookUp::nearest}) {
      CloudScene s = sunny();
      s.options.samples = 10;
      s.options.look_up = look_up;
      VolumeOptions o = s.volume_options();
      std::optional<Film> plain;
      for (const MicroBoundsUse use : {MicroBoundsUse::none, MicroBoundsUse::codes}) {
        for (const bool share : {false, true}) {
          o.micro_bounds = use, o.samples = share ? SampleStorage::shared : SampleStorage::copied;
          const Volume v = pvol::make_volume(puff().grid, pyramid, s.medium.medium(), o);
          const Film film = render_with(kernel, {"", s, {v}}, s);
          if (!plain) plain = film;
          EXPECT_TRUE(same_bytes(*plain, film)) << name(use) << (share ? ", shared" : ", copied");
        }
      }
    }
  }
}

}  // namespace wavefront_look_ups_test
}  // namespace pvol::test
