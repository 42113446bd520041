#include "pvol/form/body.h"

#include <gtest/gtest.h>

#include <random>

namespace pvol {
namespace body_test {

using Random = std::mt19937_64;

double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
Vec3d point(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
Vec3d point_in(Random& random, const Box& b) {
  return {uniform(random, b.lo.x, b.hi.x), uniform(random, b.lo.y, b.hi.y),
          uniform(random, b.lo.z, b.hi.z)};
}
Box random_box(Random& random) {
  const Vec3d centre = point(random, 2);
  const Vec3d half = Vec3d(std::exp(uniform(random, -8, 0.5))) * (point(random, 0.5) + Vec3d(0.5));
  return {centre - half, centre + half};
}

FreeForm ball(Vec3d centre, double radius) {
  return {0.5 * radius * ellipsoid(centre, Vec3d(radius)), {}};
}

FreeForm random_form(Random& random) {
  if (random() % 4 == 0) return {half_space(point(random, 1), point(random, 1)), {}};
  FreeForm form = ball(point(random, 1.5), uniform(random, 0.2, 1.5));
  if (random() % 2) {
    FreeForm bump{ellipsoid(point(random, 1.5), Vec3d(0.8)), {}};
    bump.perturbations.push_back(
        {{ellipsoid(point(random, 1.5), Vec3d(0.6)), {}}, uniform(random, -1, 1)});
    form.perturbations.push_back({bump, uniform(random, -0.5, 0.5)});
  }
  return form;
}

Body random_body(Random& random, int levels) {
  if (levels == 0 || random() % 4 == 0) return random_form(random);
  std::vector<Body> parts(1 + random() % 5);
  for (Body& part : parts) part = random_body(random, levels - 1);
  constexpr BodyOp kOps[] = {BodyOp::join, BodyOp::intersection, BodyOp::difference};
  return {kOps[random() % 3], std::move(parts)};
}

TEST(Body, OperationsAreThoseOfSets) {
  Random random(1);
  const FreeForm a = ball({}, 1), b = ball({0.5, 0, 0}, 0.8), c = ball({0, 0.6, 0}, 0.5);
  const Body all{BodyOp::join, {a, b, c}}, common{BodyOp::intersection, {a, b, c}},
      rest{BodyOp::difference, {a, b, c}};
  for (int n = 0; n < 5000; ++n) {
    const Vec3d p = point(random, 1.5);
    const bool in_a = value(a, p) >= 0, in_b = value(b, p) >= 0, in_c = value(c, p) >= 0;
    EXPECT_EQ(value(all, p) >= 0, in_a || in_b || in_c);
    EXPECT_EQ(value(common, p) >= 0, in_a && in_b && in_c);
    EXPECT_EQ(value(rest, p) >= 0, in_a && !in_b && !in_c);
  }
}

TEST(Body, ViewHasTheValueOfTheTreeToTheLastBit) {
  Random random(2);
  for (int n = 0; n < 500; ++n) {
    const Body body = random_body(random, 4);
    const BodyView all = view(body);
    for (int s = 0; s < 50; ++s) {
      const Vec3d p = point(random, 2);
      ASSERT_EQ(value(all, p), value(body, p));
    }
  }
}

TEST(Body, NarrowedViewHasTheSameValuesInTheBoxAndItsRangeHoldsThem) {
  Random random(3);
  std::size_t parts = 0, left = 0;
  const auto leaves = [](const auto& self, const BodyView& v) -> std::size_t {
    std::size_t count = v.form != nullptr;
    for (const BodyView& part : v.parts) count += self(self, part);
    return count;
  };
  for (int n = 0; n < 3000; ++n) {
    const Body body = random_body(random, 3);
    const Box box = random_box(random);
    const NarrowedBody near = narrow(view(body), box);
    EXPECT_EQ(range(body, box), near.range);
    parts += leaves(leaves, view(body));
    left += leaves(leaves, near.view);
    for (int s = 0; s < 40; ++s) {
      const Vec3d p = point_in(random, box);
      const double v = value(body, p);
      ASSERT_EQ(value(near.view, p), v);
      ASSERT_TRUE(near.range.contains(v)) << n;
    }
  }
  EXPECT_LT(left, parts / 2);  // it does leave parts out
}

TEST(Body, RangeOfASmallBoxIsNarrow) {
  Random random(4);
  for (int n = 0; n < 300; ++n) {
    const Body body = random_body(random, 3);
    const Vec3d p = point(random, 2);
    const Interval r = range(body, {p - Vec3d(1e-7), p + Vec3d(1e-7)});
    EXPECT_LT(r.width(), 1e-4);
  }
}

TEST(Body, BoundsHoldTheBodyAtEveryLevel) {
  Random random(5);
  int bounded = 0;
  for (int n = 0; n < 1000; ++n) {
    const Body body = random_body(random, 3);
    const double level = uniform(random, -0.3, 0.3);
    const Box box = bounds(body, level);
    bounded += !box.empty() && is_finite(box.lo) && is_finite(box.hi);
    for (int s = 0; s < 100; ++s) {
      const Vec3d p = point(random, 3);
      if (value(body, p) >= level) {
        ASSERT_TRUE(box.contains(p)) << n;
      }
    }
  }
  EXPECT_GT(bounded, 200);
}

TEST(Body, MovesAndScalesAsAWhole) {
  Random random(6);
  const Affine map = translation({1, 2, 3}) * scaling({2, 0.5, 1});
  for (int n = 0; n < 200; ++n) {
    const Body body = random_body(random, 3);
    const Body moved = 3 * transform(map, body);
    const Vec3d p = point(random, 2);
    const double v = 3 * value(body, p);
    EXPECT_NEAR(value(moved, map.point(p)), v, 1e-9 * (1 + std::abs(v)));
  }
}

TEST(Body, CountsItsQuadricsAndLevels) {
  const FreeForm a = ball({}, 1);
  EXPECT_EQ(count_quadrics(a), 1u);
  EXPECT_EQ(depth(Body(a)), 0);
  const Body tree{BodyOp::difference, {Body{BodyOp::join, {a, a}}, a}};
  EXPECT_EQ(count_quadrics(tree), 3u);
  EXPECT_EQ(depth(tree), 2);
  const FreeForm bump{a.base, {{{a.base, {{a, 1}}}, 1}, {a, 1}}};
  EXPECT_EQ(count_quadrics(Body{BodyOp::join, {bump, a}}), 5u);
}

}  // namespace body_test
}  // namespace pvol
