// Bounds that do not bound: found and named, made up for by trackers with weights up to a factor of
// three, refused by the others and beyond.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/statistics.h"

namespace pvol::test {
namespace wrong_bounds_test {

/// Thin enough for weights to stay tame: an optical depth of about one half.
constexpr double kExtinction = 0.04;

CloudScene scene_of(Tracker tracker, std::uint64_t seed) {
  CloudScene s;
  s.medium.extinction = kExtinction;
  s.medium.albedo = Rgb(0.9f);
  s.environment = ConstantSky{Rgb(1.0f)};
  s.lights = {Sun{{0.3, 0.8, 0.4}, Rgb(2.0f), 0}};
  s.options.tracker = tracker;
  s.options.transmittance = Transmittance::ratio;
  s.options.width = s.options.height = 16;
  s.options.samples = proof::samples(1024u);
  s.options.seed = seed;
  return s;
}

const Field& cloud() {
  static const Field f = make_field("cloud", {0, 0, 0}, {20, 20, 20}, [](Vec3i p) {
    return 0.5 + 0.5 * double((p.x * 5 + p.y * 3 + p.z * 7) % 8) / 8;
  });
  return f;
}

/// The pyramid with all majorants of leaves, and those above, divided.
Pyramid too_low(double by) {
  Pyramid p = build_pyramid(cloud().grid);
  for (auto& level : p.levels) {
    for (PyramidNode& n : level) {
      n.hi = float(double(n.hi) / by);
      n.lo = std::min(n.lo, n.hi);
    }
  }
  return p;
}

Film picture(CloudScene s, const Pyramid& p) {
  const Volume v = make_volume(cloud().grid, p, s);
  s.camera = frame(v.density.world_box, 1);
  return render(v, s).film;
}

TEST(WrongBounds, WeightsMakeUpForThem) {
  const Film truth = picture(scene_of(Tracker::delta, 1), build_pyramid(cloud().grid));
  proof::Family family;
  std::uint64_t seed = 2;
  for (const Tracker tracker : {Tracker::weighted_delta, Tracker::weighted_decomposition}) {
    for (const Transmittance t :
         {Transmittance::ratio, Transmittance::analog, Transmittance::residual_ratio}) {
      for (const double factor : {1.5, 2.9}) {
        CloudScene s = scene_of(tracker, ++seed);
        s.options.transmittance = t;
        const std::string name =
            std::string(label(tracker)) + " " + label(t) + " " + std::to_string(factor);
        compare(truth, picture(s, too_low(factor)), name, family);
        s.options.majorant_scale = 1 / factor;
        s.options.seed = ++seed;
        compare(truth, picture(s, build_pyramid(cloud().grid)), name + " by option", family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Minorants that equal majorants promise that mu_t is known, which bounds in doubt cannot.
TEST(WrongBounds, NoOtherCubesClaimToKnowTheDensity) {
  const auto claims = [](const CloudScene& s, const Pyramid& p) {
    std::size_t count = 0;
    const Volume v = make_volume(cloud().grid, p, s);
    for (const Octree::Entry& e : v.density.octree.entries) {
      EXPECT_LE(e.lo, e.hi);
      count += e.hi > 0 && e.lo > 0.5f * e.hi;
    }
    return count;
  };
  CloudScene s = scene_of(Tracker::weighted_decomposition, 1);
  s.medium.extinction = 50;  // walks go down to the leaves
  EXPECT_GT(claims(s, build_pyramid(cloud().grid)), 0u);
  EXPECT_EQ(claims(s, too_low(2.9)), 0u);
  s.options.majorant_scale = 0.5;
  EXPECT_EQ(claims(s, build_pyramid(cloud().grid)), 0u);
  s.options.majorant_scale = 1.5;
  EXPECT_EQ(claims(s, too_low(1.4)), 0u);
}

TEST(WrongBounds, AreCountedAndPlaced) {
  CloudScene s = scene_of(Tracker::weighted_delta, 1);
  const Volume v = make_volume(cloud().grid, too_low(2), s);
  EXPECT_GT(v.density.excess.nodes, 0u);
  EXPECT_NEAR(v.density.excess.factor, 2, 0.01);
  EXPECT_NEAR(v.density.majorant_excess, 2, 0.01);
  EXPECT_EQ(v.density.excess.worst.extent(), Vec3d(8));
  s.options.majorant_scale = 0.8;
  EXPECT_NEAR(make_volume(cloud().grid, too_low(2), s).density.majorant_excess, 2.5, 0.01);
  s.options.majorant_scale = 2.5;
  EXPECT_EQ(make_volume(cloud().grid, too_low(2), s).density.majorant_excess, 1);
  EXPECT_EQ(make_volume(cloud().grid, build_pyramid(cloud().grid), scene_of(Tracker::delta, 1))
                .density.excess.nodes,
            0u);
}

std::string refusal(const CloudScene& s, const Pyramid& p) {
  try {
    (void)make_volume(cloud().grid, p, s);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(WrongBounds, AreRefusedByOtherTrackersAndBeyondThree) {
  for (const Tracker t : kTrackers) {
    const std::string message = refusal(scene_of(t, 1), too_low(1.1));
    if (is_weighted(t)) {
      EXPECT_EQ(message, "");
      EXPECT_TRUE(says(refusal(scene_of(t, 1), too_low(3.1)), "bounds.cube_voxels"));
    } else {
      EXPECT_TRUE(says(message, "bounds.cube_8_3"));
    }
  }
  // The factors of the file and of the option multiply.
  CloudScene s = scene_of(Tracker::weighted_delta, 1);
  s.options.majorant_scale = 0.5;
  EXPECT_EQ(refusal(s, too_low(1.4)), "");
  EXPECT_NE(refusal(s, too_low(1.6)), "");
}

/// A minorant above one of its samples, in a cube whose majorant holds.
TEST(WrongBounds, MinorantsAreCheckedToo) {
  Pyramid p = build_pyramid(cloud().grid);
  const auto inner = std::find_if(p.levels[0].begin(), p.levels[0].end(),
                                  [](const PyramidNode& n) { return n.lo > 0 && n.lo < n.hi; });
  ASSERT_NE(inner, p.levels[0].end());
  inner->lo = 0.5f * (inner->lo + inner->hi);
  EXPECT_TRUE(says(refusal(scene_of(Tracker::decomposition, 1), p), "bounds.cube_8_3_voxels"));
  const Volume v = make_volume(cloud().grid, p, scene_of(Tracker::weighted_decomposition, 1));
  EXPECT_EQ(v.density.excess.nodes, 1u);
  EXPECT_EQ(v.density.excess.factor, 1);
}

TEST(WrongBounds, ScalesOutsideTheRangeAreRefused) {
  for (const Tracker t : kTrackers) {
    CloudScene s = scene_of(t, 1);
    for (const double scale : {0.0, -1.0, 0.3, 1001.0, 0.5}) {
      s.options.majorant_scale = scale;
      const bool refused = !refusal(s, build_pyramid(cloud().grid)).empty();
      EXPECT_EQ(refused, !(scale == 0.5 && is_weighted(t))) << label(t) << ' ' << scale;
    }
  }
}

TEST(WrongBounds, NoOtherTrackerRendersAVolumeMadeForWeights) {
  CloudScene s = scene_of(Tracker::weighted_delta, 1);
  s.options.majorant_scale = 0.5;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  s.options.tracker = Tracker::delta;
  EXPECT_THROW((void)render(v, s), Error);
}

TEST(WrongBounds, LooserOnesChangeNoMean) {
  const Film truth = picture(scene_of(Tracker::delta, 1), build_pyramid(cloud().grid));
  proof::Family family;
  std::uint64_t seed = 100;
  for (const Tracker tracker : kTrackers) {
    for (const double scale : {2.0, 10.0}) {
      CloudScene s = scene_of(tracker, ++seed);
      s.options.majorant_scale = scale;
      compare(truth, picture(s, build_pyramid(cloud().grid)),
              std::string(label(tracker)) + " " + std::to_string(scale), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace wrong_bounds_test
}  // namespace pvol::test
