// What the lane kernels owe to every scene: the means of flights one by one, and bytes that hang
// neither on the width of registers nor on what is traced beside.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "support/cloud_scene.h"
#include "support/pictures.h"
#include "support/simd_kernels.h"

namespace pvol::test {

/// A scene, and the volumes in it.
struct Shot {
  std::string name;
  CloudScene scene;
  std::vector<Volume> volumes;
};

/// "a fire, guided" or "a fire, plain".
[[nodiscard]] inline std::string name_of(const std::string& shot, GuideUse guide) {
  return shot + (guide == GuideUse::on ? ", guided" : ", plain");
}

/// How to guide the next scene of a list: both ways, and on each commit one of them, which the
/// scenes take in turns. Tests that begin with the other way render on a commit what the rest of
/// them do not.
[[nodiscard]] inline std::vector<GuideUse> guides_in_turn(std::size_t number, GuideUse first) {
  const GuideUse other = first == GuideUse::on ? GuideUse::off : GuideUse::on;
  if (proof::runs_all()) return {GuideUse::on, GuideUse::off};
  return {number % 2 == 0 ? first : other};
}

[[nodiscard]] inline Film render_with(KernelKind kernel, const Shot& shot, CloudScene s) {
  s.options.kernel = kernel;
  return render(shot.volumes, s).film;
}

/// The widest kernel with twice as many samples as flights one by one.
inline void expect_means_of_flights_one_by_one(const std::vector<Shot>& shots,
                                               std::uint32_t samples) {
  const std::vector<KernelKind> kernels = simd_kernels();
  if (kernels.empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  proof::Family family;
  proof::Moments deviations;
  for (const Shot& shot : shots) {
    CloudScene s = shot.scene;
    s.options.samples = proof::samples(samples, 8u);
    const Film scalar = render_with(KernelKind::scalar, shot, s);
    s.options.samples = proof::samples(2 * samples, 8u);
    s.options.seed = 2;
    const Film lanes = render_with(kernels.back(), shot, s);
    compare(scalar, lanes, shot.name, family);
    deviations.add(compare(average(lanes), average(scalar), shot.name + ", again", family));
    EXPECT_EQ(scalar.layers.size(), lanes.layers.size());
  }
  add_all_together(deviations, family);
  EXPECT_TRUE(family.passes());
}

/// Sums and layers.
inline void expect_same_at_every_width(const std::vector<Shot>& shots) {
  const std::vector<KernelKind> kernels = fusing_kernels();
  if (kernels.size() < 2) GTEST_SKIP() << "the machine has one SIMD kernel at most";
  for (const Shot& shot : shots) {
    CloudScene s = shot.scene;
    s.options.samples = 5;
    const Film a = render_with(kernels[0], shot, s), b = render_with(kernels[1], shot, s);
    EXPECT_TRUE(same_bytes(a, b)) << shot.name;
    ASSERT_EQ(a.layers.size(), b.layers.size());
    for (std::size_t k = 0; k < a.layers.size(); ++k) {
      EXPECT_EQ(a.layers[k].sums, b.layers[k].sums) << shot.name << ": " << a.layers[k].name;
    }
  }
}

/// By other threads, and in a crop.
inline void expect_same_in_any_company(const std::vector<Shot>& shots) {
  for (const KernelKind kernel : kernels_to_try()) {
    for (const Shot& shot : shots) {
      CloudScene s = shot.scene;
      s.options.samples = 20;
      const Film whole = render_with(kernel, shot, s);
      s.options.threads = 7;
      EXPECT_TRUE(same_bytes(whole, render_with(kernel, shot, s))) << shot.name;
      s.options.crop_x = 5, s.options.crop_y = 6;
      s.options.crop_width = 3, s.options.crop_height = 4;
      const Film crop = render_with(kernel, shot, s);
      for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 3; ++x) {
          EXPECT_TRUE(same_bytes(crop.at(x, y), whole.at(5 + x, 6 + y))) << shot.name;
        }
      }
    }
  }
}

}  // namespace pvol::test
