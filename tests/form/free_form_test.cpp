#include "pvol/form/free_form.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/shell_samples.h"

namespace pvol {
namespace free_form_test {

using Random = std::mt19937_64;

double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
double log_uniform(Random& random, double lo, double hi) {
  return std::exp(uniform(random, std::log(lo), std::log(hi)));
}
Vec3d point(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
Vec3d point_in(Random& random, const Box& b) {
  Vec3d p;
  for (int i = 0; i < 3; ++i) {
    const double side = uniform(random, 0, 4);
    p[i] = side < 1 ? b.lo[i] : side < 2 ? b.hi[i] : uniform(random, b.lo[i], b.hi[i]);
  }
  return p;
}

Quadric random_quadric(Random& random) {
  const double scale = log_uniform(random, 1e-3, 1e3);
  return {point(random, scale), point(random, scale), point(random, scale),
          uniform(random, -scale, scale)};
}

FreeForm random_form(Random& random) {
  FreeForm form{random_quadric(random), {}};
  const int count = int(uniform(random, 0, 6));
  for (int i = 0; i < count; ++i) {
    form.perturbations.push_back({{random_quadric(random), {}}, uniform(random, -1, 1)});
  }
  return form;
}

/// A ball of radius 1 with a bulge towards +x and a dent towards +y.
FreeForm bulged_ball() {
  return {unit_ball(),
          {{{ellipsoid({1, 0, 0}, Vec3d(0.8)), {}}, 1.5},
           {{ellipsoid({0, 1, 0}, Vec3d(0.6)), {}}, -2}}};
}

TEST(FreeForm, RangeHoldsTheValueAtEveryPointOfTheBox) {
  Random random(1);
  for (int n = 0; n < 20000; ++n) {
    const FreeForm form = random_form(random);
    const Vec3d centre = point(random, log_uniform(random, 1e-2, 10));
    const Vec3d half{log_uniform(random, 1e-6, 1e2), log_uniform(random, 1e-6, 1e2),
                     log_uniform(random, 1e-6, 1e2)};
    const Box b{centre - half, centre + half};
    const Interval r = range(form, b);
    for (int s = 0; s < 50; ++s) {
      ASSERT_TRUE(r.contains(value(form, point_in(random, b)))) << n;
    }
  }
}

TEST(FreeForm, ExcessOfTheRangeFallsWithTheSquareOfTheBox) {
  const FreeForm form = bulged_ball();
  Random random(2);
  for (int n = 0; n < 200; ++n) {
    const Vec3d centre = point(random, 1.2), g = gradient(form, centre);
    const double slope = std::abs(g.x) + std::abs(g.y) + std::abs(g.z);
    for (double half = 1e-2; half > 1e-5; half *= 0.5) {
      const Box b{centre - Vec3d(half), centre + Vec3d(half)};
      // Second derivatives of this form stay below 100.
      EXPECT_LE(range(form, b).width(), 2 * half * slope + 600 * half * half + 1e-12);
    }
  }
}

/// Forms within forms, `levels` deep.
FreeForm nested_form(Random& random, int levels) {
  FreeForm form{random_quadric(random), {}};
  for (int i = levels > 0 ? int(uniform(random, 1, 4)) : 0; i > 0; --i) {
    form.perturbations.push_back({nested_form(random, levels - 1), uniform(random, -1, 1)});
  }
  return form;
}

TEST(FreeForm, RangeOfNestedFormsHoldsTheExactValueAndTheComputedOne) {
  Random random(6);
  for (int n = 0; n < 5000; ++n) {
    const FreeForm form = nested_form(random, 1 + n % 3);
    const Vec3d centre = point(random, log_uniform(random, 1e-2, 3));
    const double half = log_uniform(random, 1e-9, 3);
    const Box b{centre - Vec3d(half), centre + Vec3d(half)};
    const Interval r = range(form, b);
    const double error = rounding_error(form, b);
    for (int s = 0; s < 30; ++s) {
      const Vec3d p = point_in(random, b);
      const double computed = value(form, p);
      const long double exact = proof::exact_value(form, proof::Vec3x(p));
      ASSERT_TRUE(r.contains(computed)) << n;
      ASSERT_TRUE(r.lo <= exact && exact <= r.hi) << n;
      ASSERT_LE(std::abs(computed - exact), error) << n;
    }
  }
}

/// Like a fitted shell: 16 perturbations with coefficients of 5 to 30 in a frame of half extent 1.
FreeForm shell_like(proof::Draw& draw) {
  FreeForm form{ellipsoid({}, Vec3d(1.1)), {}};
  for (int i = 0; i < 16; ++i) {
    form.perturbations.push_back(
        {{proof::random_side(draw, draw.uniform(5, 20)), {}}, draw.index(3) ? -1.0 : 0.5});
  }
  return form;
}

double sampled_width(const FreeForm& form, const Box& b) {
  double least = value(form, b.lo), most = least;
  for (int i = 0; i < 9 * 9 * 9; ++i) {
    const Vec3d step = Vec3d{double(i % 9), double(i / 9 % 9), double(i / 81)} * 0.125;
    const double v = value(form, b.lo + b.extent() * step);
    least = std::min(least, v);
    most = std::max(most, v);
  }
  return most - least;
}

TEST(FreeForm, RangesOfShellsAreTightInSmallBoxes) {
  proof::Draw draw(7);
  double coarse = 0, fine = 0;
  int boxes = 0;
  while (boxes < 500) {
    const FreeForm form = shell_like(draw);
    const Vec3d corner = draw.point(1);
    if (std::abs(value(form, corner)) > 5) continue;  // where no shell has its surface
    const auto excess = [&](double edge) {
      const Box b{corner, corner + Vec3d(edge)};
      const double width = sampled_width(form, b);
      return (range(form, b).width() - width) / width;
    };
    ++boxes;
    coarse += excess(1.0 / 64);
    fine += excess(1.0 / 1024);
  }
  EXPECT_LT(coarse / boxes, 0.2);
  EXPECT_LT(fine / boxes, 0.02);
}

TEST(FreeForm, IsItsBaseOutsideAllPerturbations) {
  const FreeForm form = bulged_ball();
  for (const Vec3d p : {Vec3d{-1, 0, 0}, Vec3d{0, 0, 1}, Vec3d{0, -0.5, 0}}) {
    EXPECT_EQ(value(form, p), value(form.base, p));
    EXPECT_EQ(gradient(form, p), gradient(form.base, p));
  }
  EXPECT_GT(value(form, {1.2, 0, 0}), 0);   // bulged out
  EXPECT_LT(value(form, {0, 0.95, 0}), 0);  // dented in
}

TEST(FreeForm, GradientIsTheSlopeOfTheValueAlsoAcrossThePerturbationsEdge) {
  const FreeForm form = bulged_ball();
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    Vec3d p = point(random, 1.5);
    if (n % 2) p = Vec3d{1, 0, 0} + normalize(point(random, 1)) * 0.8;  // on the bulge's quadric
    const Vec3d d = normalize(point(random, 1));
    const double h = 1e-5;
    const double slope = (value(form, p + d * h) - value(form, p - d * h)) / (2 * h);
    EXPECT_NEAR(dot(gradient(form, p), d), slope, 1e-3);
  }
}

TEST(FreeForm, BoundsHoldTheBodyWithItsBulges) {
  const FreeForm form = bulged_ball();
  const Box b = bounds(form);
  EXPECT_NEAR(b.hi.x, 1.8, 1e-9);
  EXPECT_NEAR(b.hi.y, 1, 1e-9);  // a dent needs no room
  Random random(4);
  for (int n = 0; n < 100000; ++n) {
    const Vec3d p = point(random, 2);
    if (value(form, p) >= 0) {
      ASSERT_TRUE(b.contains(p));
    }
  }
}

TEST(FreeForm, TransformAndScaleKeepTheBody) {
  const FreeForm form = bulged_ball();
  Affine turn;
  turn.m = {Vec3d{0.6, -0.8, 0}, Vec3d{0.8, 0.6, 0}, Vec3d{0, 0, 1}};
  const Affine map = translation({3, -2, 1}) * turn * scaling({2, 0.5, 1.5});
  const FreeForm moved = transform(map, form);
  Random random(5);
  for (int n = 0; n < 1000; ++n) {
    const Vec3d p = point(random, 1.5);
    EXPECT_NEAR(value(moved, map.point(p)), value(form, p), 1e-10);
    EXPECT_NEAR(value(3.0 * form, p), 3 * value(form, p), 1e-12);
  }
}

}  // namespace free_form_test
}  // namespace pvol
