// Fields whose densities the lane kernels look up one by one: against the scalar tracers, and
// against themselves.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/math/field_map.h"
#include "support/lit_scenes.h"
#include "support/pictures.h"
#include "support/recipes.h"
#include "support/simd_kernels.h"

namespace pvol::test {
namespace wavefront_look_ups_test {

struct Shot {
  std::string name;
  CloudScene scene;
  Volume volume;
};

std::vector<Shot> shots() {
  std::vector<Shot> all;
  const VoxelGrid& grid = puff().grid;
  const auto add = [&](const std::string& name, CloudScene s, const auto& make) {
    for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
      s.options.guide = guide;
      Volume v = make(s);
      s.camera = frame(v.density.world_box, 1);
      all.push_back({name + (guide == GuideUse::on ? ", guided" : ", plain"), s, std::move(v)});
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
        with([](VolumeOptions& o) { o.share_samples = true; }));
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

Film render_with(KernelKind kernel, const Shot& shot, CloudScene s) {
  s.options.kernel = kernel;
  return render(std::span<const Volume>(&shot.volume, 1), s).film;
}

TEST(WavefrontLookUps, HaveTheMeansOfTheScalarTracer) {
  const std::vector<KernelKind> kernels = simd_kernels();
  if (kernels.empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  proof::Family family;
  proof::Moments deviations;
  for (const Shot& shot : shots()) {
    CloudScene s = shot.scene;
    s.options.samples = proof::samples(300);
    const Film scalar = render_with(KernelKind::scalar, shot, s);
    s.options.samples = proof::samples(600);
    s.options.seed = 2;
    const Film lanes = render_with(kernels.back(), shot, s);
    compare(scalar, lanes, shot.name, family);
    deviations.add(compare(average(lanes), average(scalar), shot.name + ", again", family));
  }
  add_all_together(deviations, family);
  EXPECT_TRUE(family.passes());
}

TEST(WavefrontLookUps, OfEveryWidthGiveTheSameBytes) {
  const std::vector<KernelKind> kernels = simd_kernels();
  if (kernels.size() < 2) GTEST_SKIP() << "the machine has one SIMD kernel at most";
  for (const Shot& shot : shots()) {
    CloudScene s = shot.scene;
    s.options.samples = 5;
    EXPECT_TRUE(same_bytes(render_with(kernels[0], shot, s), render_with(kernels[1], shot, s)))
        << shot.name;
  }
}

/// Shared samples are looked up one by one, copied ones in lanes: the decisions are the same.
TEST(WavefrontLookUps, OfSharedSamplesChangeNoBit) {
  for (const KernelKind kernel : simd_kernels()) {
    CloudScene s = sunny();
    s.options.samples = 10;
    Volume copied = volume_of(s);
    VolumeOptions o = s.volume_options();
    o.share_samples = true;
    const Volume shared =
        pvol::make_volume(puff().grid, build_pyramid(puff().grid), s.medium.medium(), o);
    EXPECT_TRUE(same_bytes(render_with(kernel, {"copied", s, std::move(copied)}, s),
                           render_with(kernel, {"shared", s, shared}, s)));
  }
}

}  // namespace wavefront_look_ups_test
}  // namespace pvol::test
