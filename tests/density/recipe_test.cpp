#include "pvol/density/recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pvol/error.h"
#include "support/messages.h"
#include "support/recipes.h"

namespace pvol {
namespace recipe_test {

using test::ball;
using test::kRecipes;
using test::make_plain;
using test::make_sample;
using test::point_in;
using test::Random;
using test::uniform;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

FreeForm nested(int levels) {
  FreeForm form = ball({}, 1);
  if (levels > 0) form.perturbations = {{nested(levels - 1), 0.1}};
  return form;
}

Body stacked(int levels) {
  if (levels == 0) return ball({}, 1);
  return {BodyOp::join, {stacked(levels - 1), ball({}, 0.5)}};
}

/// Most that the density can be.
double most(const Recipe& r) {
  double factor = 1, solid = 0;
  for (const MaskedNoise& n : r.modulations) factor += std::max(0.0, n.amplitude);
  for (const Solid& s : r.solids) solid = std::max(solid, s.density);
  return std::max(r.density * largest(r.profile) * factor, solid) * (1 + 1e-12);
}

TEST(Recipe, DensityRangeHoldsTheDensityAtEveryPointOfTheBox) {
  Random random(1);
  for (const Recipe& r : kRecipes) {
    const Box all = support(r);
    for (int n = 0; n < 1000; ++n) {
      const Vec3d centre = point_in(random, all);
      const Vec3d half = Vec3d(std::exp(uniform(random, -8, 0)));
      const Box b{centre - half, centre + half};
      const Interval range = density_range(r, b);
      EXPECT_GE(range.lo, 0);
      EXPECT_LE(range.hi, most(r));
      for (int s = 0; s < 50; ++s) {
        ASSERT_TRUE(range.contains(density(r, point_in(random, b))));
      }
    }
  }
}

TEST(Recipe, DensityIsZeroOutsideTheSupport) {
  Random random(2);
  for (const Recipe& r : kRecipes) {
    const Box b = support(r);
    ASSERT_FALSE(b.empty());
    const Box around{b.lo - b.extent() * 0.2, b.hi + b.extent() * 0.2};
    int inside = 0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3d p = point_in(random, around);
      if (b.contains(p)) {
        inside += density(r, p) > 0;
      } else {
        ASSERT_EQ(density(r, p), 0);
      }
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(Recipe, DensityRangeIsZeroOutsideTheSupport) {
  // Far from a tall form the range of the bump upon it is loose: sampling took a minute.
  Recipe r;
  r.voxel = 0.6;
  FreeForm dome{0.25 * ellipsoid({1, 0.85, 0}, Vec3d{0.5, 80.4, 0.5}), {}};
  dome.perturbations = {{ball({0, 1.25, 0}, 0.3), 0.35}};
  dome.perturbations[0].form.perturbations = {{ball({0, 1.5, 0}, 0.2), 1.5}};
  r.forms = {dome};
  const Box b = support(r);
  for (const double away : {1e-6, 1.0, 40.0, 1000.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      Box outside = b;
      outside.lo[axis] = b.hi[axis] + away;
      outside.hi[axis] = outside.lo[axis] + 5;
      EXPECT_EQ(density_range(r, outside), Interval(0)) << away;
    }
  }
}

TEST(Recipe, DensityRisesOverTheEdge) {
  Recipe r;
  r.forms = {FreeForm{half_space({}, {0, -1, 0}), {}}};
  r.cuts = {ball({}, 100)};
  r.edge = 0.5;
  r.density = 3;
  EXPECT_EQ(density(r, {0, 0.1, 0}), 0);
  EXPECT_DOUBLE_EQ(density(r, {0, -0.25, 0}), 1.5);
  EXPECT_EQ(density(r, {0, -0.6, 0}), 3);
}

TEST(Recipe, MovedFormsMakeTheMovedCloud) {
  const Recipe r = make_plain();
  Recipe moved = r;
  Affine map = translation({1, 2, 3}) * scaling({2, 2, 2});
  map.m = {Vec3d{0, -2, 0}, Vec3d{2, 0, 0}, Vec3d{0, 0, 2}};  // a quarter turn
  for (Body& form : moved.forms) form = transform(map, form);
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    const Vec3d p = point_in(random, support(r));
    EXPECT_NEAR(density(moved, map.point(p)), density(r, p), 1e-10);
  }
}

TEST(Recipe, MaskLimitsADisplacement) {
  Recipe r;
  r.forms = {ball({}, 1)};
  Recipe rough = r;
  rough.displacements = {{{1, 0.3, 3, 0.5, true}, 0.3, 1e6 * half_space({}, {0, 1, 0})}};
  Random random(4);
  int different = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vec3d p = point_in(random, {Vec3d(-1.2), Vec3d(1.2)});
    if (p.y < 0) {
      EXPECT_EQ(density(rough, p), density(r, p));
    } else {
      different += density(rough, p) != density(r, p);
    }
  }
  EXPECT_GT(different, 100);
}

TEST(Recipe, ProfileIsWhatItSays) {
  const Profile smooth{ProfileKind::smooth, {}};
  const Profile table{ProfileKind::table, {{-1, 0}, {0, 0}, {1, 2}, {3, 1}}};
  EXPECT_EQ(value({}, 0.25), 0.25);
  EXPECT_EQ(value(smooth, 0.25), 0.15625);
  EXPECT_EQ(value(smooth, 7), 1);
  EXPECT_EQ(value(table, -0.5), 0);
  EXPECT_EQ(value(table, 0.5), 1);
  EXPECT_EQ(value(table, 2), 1.5);
  EXPECT_EQ(value(table, 9), 1);
  EXPECT_EQ(start(table), 0);
  EXPECT_EQ(largest(table), 2);
  EXPECT_EQ(range(table, {0.5, 2}), Interval(1, 2));
  EXPECT_EQ(range(table, {1.5, 9}), Interval(1, 1.75));
  EXPECT_EQ(range(table, {-kInfinity, kInfinity}), Interval(0, 2));
  EXPECT_EQ(range(smooth, {1, 5}), Interval(1, 1));
}

TEST(Recipe, ProfileRangeIsAttained) {
  Random random(5);
  for (int n = 0; n < 3000; ++n) {
    Profile profile{n % 2 ? ProfileKind::table : ProfileKind::smooth, {}};
    double at = uniform(random, -2, 0);
    for (int i = 0; i < 5; ++i) {
      profile.points.push_back({at, i == 0 ? 0 : uniform(random, 0, 3)});
      at += std::exp(uniform(random, -20, 1));
    }
    const double lo = uniform(random, -3, 3), width = std::exp(uniform(random, -30, 2));
    const Interval r = range(profile, {lo, lo + width});
    Interval found = hull(value(profile, lo), value(profile, lo + width));
    for (const ProfilePoint& p : profile.points) {
      if (lo <= p.depth && p.depth <= lo + width) found = hull(found, value(profile, p.depth));
    }
    for (int s = 0; s <= 50; ++s) {
      const double v = value(profile, std::min(lo + width, lo + width * s / 50));
      ASSERT_TRUE(r.contains(v)) << n;
      found = hull(found, v);
    }
    EXPECT_NEAR(r.lo, found.lo, 1e-14);
    EXPECT_NEAR(r.hi, found.hi, 1e-14);
  }
}

TEST(Recipe, ModulationMultipliesTheDensityAndNeverBelowZero) {
  Recipe r;
  r.forms = {ball({}, 1)};
  r.edge = 0.01;
  Recipe rough = r;
  rough.modulations = {{{1, 0.3, 2, 0.5, false}, 3}};
  Random random(6);
  int gaps = 0;
  for (int n = 0; n < 3000; ++n) {
    const Vec3d p = point_in(random, {Vec3d(-0.5), Vec3d(0.5)});
    const double expected = std::max(0.0, 1 + 3 * fbm(rough.modulations[0].noise, p));
    EXPECT_DOUBLE_EQ(density(rough, p), expected * density(r, p));
    gaps += expected == 0;
  }
  EXPECT_GT(gaps, 10);
  EXPECT_EQ(density(rough, {2, 0, 0}), 0);
}

TEST(Recipe, SolidStandsInTheCloud) {
  Recipe r;
  r.forms = {ball({}, 1)};
  r.solids = {{ball({0.8, 0, 0}, 0.5), 20, 0.01}};
  EXPECT_EQ(density(r, {0.9, 0, 0}), 20);
  EXPECT_EQ(density(r, {1.2, 0, 0}), 20);  // also where it looks out of the cloud
  EXPECT_EQ(density(r, {-0.5, 0, 0}), 1);
  EXPECT_EQ(density(r, {0, 1.1, 0}), 0);
  EXPECT_EQ(density_range(r, {{0.8, -0.1, -0.1}, {0.9, 0.1, 0.1}}), Interval(20));
  r.forms.clear();  // alone
  EXPECT_EQ(density(r, {0.9, 0, 0}), 20);
  EXPECT_EQ(density(r, {-0.5, 0, 0}), 0);
  EXPECT_FALSE(make_grid(r).bricks.empty());
}

TEST(Recipe, DeepestTreesAreValid) {
  Recipe r;
  r.forms = {stacked(kDeepestTree), nested(kDeepestTree)};
  EXPECT_NO_THROW(validate(r));
}

std::string refusal(const Recipe& r) {
  try {
    static_cast<void>(make_grid(r));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Recipe, RefusesWhatIsOutOfRangeByName) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [](const std::string& key, auto change) {
    Recipe r = make_sample();
    change(r);
    EXPECT_TRUE(says(refusal(r), key));
  };
  refuses("recipe.voxel", [](Recipe& r) { r.voxel = 0; });
  refuses("recipe.voxel_nan", [](Recipe& r) { r.voxel = kNan; });
  refuses("recipe.longest_side_samples",
          [](Recipe& r) { r.voxel = 1e-7; });  // 2e7 samples on a side
  refuses("recipe.density_minus", [](Recipe& r) { r.density = -1; });
  refuses("recipe.edge", [](Recipe& r) { r.edge = 0; });
  refuses("recipe.no_form", [](Recipe& r) { r.forms.clear(); });
  refuses("recipe.form_coefficient", [](Recipe& r) { r.forms[1].form.base.linear.y = kNan; });
  refuses("recipe.form_strength",
          [](Recipe& r) { r.forms[0].form.perturbations[0].strength = kNan; });
  refuses("recipe.cut_coefficient", [](Recipe& r) { r.cuts[0].form.base.constant = kNan; });
  refuses("recipe.forms_extend_infinity", [](Recipe& r) {
    r.forms.push_back(FreeForm{half_space({}, {1, 0, 0}), {}});
  });
  refuses("recipe.displacement_octaves", [](Recipe& r) { r.displacements[0].noise.octaves = 0; });
  refuses("recipe.displacement_octaves",
          [](Recipe& r) { r.displacements[0].noise.octaves = kMaxOctaves + 1; });
  refuses("recipe.displacement_gain", [](Recipe& r) { r.displacements[1].noise.gain = 0; });
  refuses("recipe.displacement_cell", [](Recipe& r) { r.displacements[1].noise.cell = -1; });
  refuses("recipe.displacement_amplitude", [](Recipe& r) { r.displacements[1].amplitude = kNan; });
  refuses("recipe.displacement_mask", [](Recipe& r) { r.displacements[1].mask.constant = kNan; });
  refuses("recipe.distance_origin", [](Recipe& r) { r.displacements[0].noise.cell = 1e-14; });
  refuses("recipe.parts_too_deep", [](Recipe& r) { r.forms[0] = stacked(kDeepestTree + 1); });
  refuses("recipe.perturbations_too_deep",
          [](Recipe& r) { r.forms[0] = nested(kDeepestTree + 1); });
  refuses("recipe.form_no_parts", [](Recipe& r) { r.forms[0] = {BodyOp::join, {}}; });
  refuses("recipe.cut_part", [](Recipe& r) {
    r.cuts[0] = {BodyOp::join, {ball({}, 1), ball({}, kNan)}};
  });
  refuses("recipe.modulation_cell", [](Recipe& r) { r.modulations = {{{.cell = 0}, 1}}; });
  refuses("recipe.largest_density", [](Recipe& r) { r.modulations = {{{}, 1e35}}; });
  refuses("recipe.solid_edge", [](Recipe& r) { r.solids = {{ball({}, 1), 1, 0}}; });
  refuses("recipe.solid_density", [](Recipe& r) { r.solids = {{ball({}, 1), kNan, 1}}; });
  refuses("recipe.solid_extends_infinity", [](Recipe& r) {
    r.solids = {{FreeForm{half_space({}, {1, 0, 0}), {}}, 1, 1}};
  });
  const auto refuses_table = [&](const std::string& word, std::vector<ProfilePoint> points) {
    refuses(word, [&](Recipe& r) { r.profile = {ProfileKind::table, points}; });
  };
  refuses_table("recipe.number_points_profile", {{0, 0}});
  refuses_table("recipe.profile_point_depth", {{0, 0}, {0, 1}});
  refuses_table("recipe.profile_point_density", {{0, -1}, {1, 1}});
  refuses_table("recipe.first_density", {{0, 1}, {1, 1}});
  refuses_table("recipe.profile_of_zeros", {{0, 0}, {1, 0}});
  refuses("recipe.distance_origin_samples", [](Recipe& r) {
    r = make_plain();
    r.forms = {ball({1e9, 0, 0}, 1)};
    r.voxel = 0.1;
  });
}

}  // namespace recipe_test
}  // namespace pvol
