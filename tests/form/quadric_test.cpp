#include "pvol/form/quadric.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace pvol {
namespace quadric_test {

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
    // Corners, faces and edges as often as the inside.
    const double side = uniform(random, 0, 4);
    p[i] = side < 1 ? b.lo[i] : side < 2 ? b.hi[i] : uniform(random, b.lo[i], b.hi[i]);
  }
  return p;
}

Quadric random_quadric(Random& random, bool with_mixed) {
  const double scale = log_uniform(random, 1e-3, 1e3);
  Quadric q{point(random, scale), with_mixed ? point(random, scale) : Vec3d{}, point(random, scale),
            uniform(random, -scale, scale)};
  // Singular and semidefinite forms, which random numbers never hit.
  const int zero = int(uniform(random, 0, 6));
  if (zero < 3) q.square[zero] = 0;
  if (zero == 4 && with_mixed) {
    const Vec3d a = point(random, std::sqrt(scale));
    q.square = -(a * a);
    q.mixed = Vec3d{a.y * a.z, a.z * a.x, a.x * a.y} * -2.0;
  }
  return q;
}

Box random_box(Random& random) {
  const Vec3d centre = point(random, log_uniform(random, 1e-2, 10));
  const Vec3d half{log_uniform(random, 1e-6, 1e2), log_uniform(random, 1e-6, 1e2),
                   log_uniform(random, 1e-6, 1e2)};
  return {centre - half, centre + half};
}

/// Sum of the absolute values of all terms: what an error counts against.
double magnitude(const Quadric& q, const Box& b) { return rounding_error(q, b) * 0x1p48; }

/// Maximum over the box by Cramer's rule on each face, in long double.
long double maximum(const Quadric& q, const Box& b) {
  using Real = long double;
  const Real h[3][3] = {{2 * Real(q.square.x), q.mixed.z, q.mixed.y},
                        {q.mixed.z, 2 * Real(q.square.y), q.mixed.x},
                        {q.mixed.y, q.mixed.x, 2 * Real(q.square.z)}};
  const Real l[3] = {q.linear.x, q.linear.y, q.linear.z};
  Real best = -std::numeric_limits<Real>::infinity();
  for (int code = 0; code < 27; ++code) {
    const int state[3] = {code % 3, code / 3 % 3, code / 9};  // lo, hi or free
    Real m[3][3], r[3], x[3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) m[i][j] = state[i] == 2 ? h[i][j] : i == j ? 1 : 0;
      r[i] = state[i] == 2 ? -l[i] : state[i] == 1 ? b.hi[i] : b.lo[i];
    }
    const auto det = [](const Real(&a)[3][3]) {
      return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
             a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
             a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    };
    const Real d = det(m);
    if (d == 0) continue;
    bool inside = true;
    for (int k = 0; k < 3; ++k) {
      Real c[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) c[i][j] = j == k ? r[i] : m[i][j];
      }
      x[k] = state[k] == 2 ? det(c) / d : r[k];
      inside = inside && x[k] >= b.lo[k] && x[k] <= b.hi[k];
    }
    if (!inside) continue;
    Real v = q.constant;
    for (int i = 0; i < 3; ++i) {
      v += l[i] * x[i];
      for (int j = 0; j < 3; ++j) v += h[i][j] * x[i] * x[j] / 2;
    }
    best = std::max(best, v);
  }
  return best;
}

TEST(Quadric, RangeHoldsTheValueAtEveryPointOfTheBox) {
  Random random(1);
  for (int n = 0; n < 20000; ++n) {
    const Quadric q = random_quadric(random, n % 3 != 0);
    const Box b = random_box(random);
    const Interval r = range(q, b);
    for (int s = 0; s < 50; ++s) {
      const Vec3d p = point_in(random, b);
      ASSERT_TRUE(r.contains(value(q, p))) << n;
    }
  }
}

TEST(Quadric, RangeIsAttainedButForRounding) {
  Random random(2);
  for (int n = 0; n < 20000; ++n) {
    const Quadric q = random_quadric(random, n % 3 != 0);
    const Box b = random_box(random);
    const Interval r = range(q, b);
    const double tolerance = 1e-9 * magnitude(q, b);
    const double most = double(maximum(q, b)), least = -double(maximum(-q, b));
    EXPECT_LE(r.hi - most, tolerance) << n;
    EXPECT_LE(least - r.lo, tolerance) << n;
    EXPECT_GE(r.hi, most) << n;
    EXPECT_LE(r.lo, least) << n;
  }
}

TEST(Quadric, RangeOfKnownFormsIsThatOfTheirExtremes) {
  const Box b{{-1, -2, -3}, {3, 2, 1}};
  const auto expect = [&](const Quadric& q, double lo, double hi) {
    const Interval r = range(q, b);
    EXPECT_NEAR(r.lo, lo, 1e-12);
    EXPECT_NEAR(r.hi, hi, 1e-12);
  };
  expect({{}, {}, {}, 5}, 5, 5);
  expect({{}, {}, {1, 1, 1}, 0}, -6, 6);
  expect({{1, 1, 1}, {}, {}, 0}, 0, 22);
  expect({{}, {0, 0, 1}, {}, 0}, -6, 6);                    // the saddle xy
  expect({{-1, -1, -1}, {-2, -2, -2}, {}, 0}, -36, 0);      // -(x + y + z)^2: flat along a plane
  expect({{-1, -1, 0}, {0, 0, -2}, {0, 0, 1}, 0}, -28, 1);  // -(x + y)^2 + z
  expect({{-1, -1, -1}, {}, {4, 0, 0}, -4}, -22, 0);        // -|p - (2, 0, 0)|^2
  expect({{-1, -1, -1}, {0, 0, 1}, {}, 0}, -28, 0);         // an inner maximum, turned
}

TEST(Quadric, RangeOfAPointIsItsValue) {
  Random random(3);
  for (int n = 0; n < 1000; ++n) {
    const Quadric q = random_quadric(random, true);
    const Vec3d p = point(random, 10);
    const Interval r = range(q, {p, p});
    EXPECT_TRUE(r.contains(value(q, p)));
    EXPECT_LE(r.width(), 1e-12 * magnitude(q, {p, p}));
  }
}

TEST(Quadric, GradientIsTheSlopeOfTheValue) {
  Random random(4);
  for (int n = 0; n < 1000; ++n) {
    const Quadric q = random_quadric(random, true);
    const Vec3d p = point(random, 3), d = point(random, 1);
    // Central differences of a quadratic are exact.
    const double slope = 0.5 * (value(q, p + d) - value(q, p - d));
    EXPECT_NEAR(dot(gradient(q, p), d), slope, 1e-12 * magnitude(q, {p - Vec3d(1), p + Vec3d(1)}));
  }
}

Affine random_map(Random& random) {
  Affine a;
  do {
    for (Vec3d& row : a.m) row = point(random, 2);
  } while (std::abs(determinant(a)) < 0.1);
  a.t = point(random, 5);
  return a;
}

Affine random_rotation(Random& random) {
  Affine a;
  a.m[0] = normalize(point(random, 1));
  orthonormal_basis(a.m[0], a.m[1], a.m[2]);
  return a;
}

TEST(Quadric, TransformMovesTheBody) {
  Random random(6);
  for (int n = 0; n < 1000; ++n) {
    const Quadric q = random_quadric(random, true);
    const Affine a = random_map(random);
    const Quadric moved = transform(a, q);
    const Vec3d p = point(random, 3);
    const double size = magnitude(moved, extend(Box{}, a.point(p)));
    EXPECT_NEAR(value(moved, a.point(p)), value(q, p), 1e-11 * size);
  }
}

TEST(Quadric, EllipsoidIsOneInItsCentreAndZeroOnItsSurface) {
  Random random(7);
  for (int n = 0; n < 1000; ++n) {
    const Vec3d centre = point(random, 3);
    const Vec3d radii{uniform(random, 0.1, 2), uniform(random, 0.1, 2), uniform(random, 0.1, 2)};
    const Affine turn = random_rotation(random);
    const Quadric q = ellipsoid(centre, radii, turn);
    EXPECT_NEAR(value(q, centre), 1, 1e-10);
    const Vec3d direction = normalize(point(random, 1));
    EXPECT_NEAR(value(q, centre + turn.vector(radii * direction)), 0, 1e-10);
  }
}

TEST(Quadric, HalfSpaceIsTheSignedDistance) {
  const Quadric q = half_space({1, 2, 3}, {0, 0, -2});
  EXPECT_DOUBLE_EQ(value(q, {7, 8, 3}), 0);
  EXPECT_DOUBLE_EQ(value(q, {7, 8, 1}), 2);
  EXPECT_DOUBLE_EQ(value(q, {7, 8, 4}), -1);
}

TEST(Quadric, BoundsTouchAnEllipsoidOnAllSides) {
  Random random(8);
  for (int n = 0; n < 1000; ++n) {
    const Vec3d centre = point(random, 3);
    const Vec3d radii{uniform(random, 0.1, 2), uniform(random, 0.1, 2), uniform(random, 0.1, 2)};
    const Affine turn = random_rotation(random);
    const Box b = bounds(ellipsoid(centre, radii, turn));
    for (int i = 0; i < 3; ++i) {
      const double reach = length(turn.m[std::size_t(i)] * radii);
      EXPECT_NEAR(b.hi[i], centre[i] + reach, 1e-9);
      EXPECT_NEAR(b.lo[i], centre[i] - reach, 1e-9);
    }
  }
}

TEST(Quadric, BoundsHoldEveryPointAboveTheLevel) {
  Random random(9);
  for (int n = 0; n < 5000; ++n) {
    const Quadric q = random_quadric(random, n % 3 != 0);
    const double level = uniform(random, -1, 1) * std::abs(q.constant);
    const Box b = bounds(q, level);
    for (int s = 0; s < 20; ++s) {
      const Vec3d p = point(random, 10);
      if (value(q, p) >= level) {
        ASSERT_TRUE(b.contains(p)) << n;
      }
    }
  }
}

TEST(Quadric, BoundsOfUnboundedAndEmptyBodiesSaySo) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Box ground = bounds(half_space({0, 2, 0}, {0, 1, 0}));
  EXPECT_NEAR(ground.lo.y, 2, 1e-12);
  EXPECT_EQ(ground.hi, Vec3d(kInfinity));
  EXPECT_EQ(ground.lo.x, -kInfinity);
  const Box slab = bounds({{0, -1, 0}, {}, {}, 4});
  EXPECT_NEAR(slab.hi.y, 2, 1e-12);
  EXPECT_EQ(slab.hi.x, kInfinity);
  const Box cylinder = bounds({{-1, -1, 0}, {0, 0, 1}, {}, 3});
  EXPECT_NEAR(cylinder.hi.x, 2, 1e-12);
  EXPECT_EQ(cylinder.hi.z, kInfinity);
  EXPECT_TRUE(bounds(unit_ball(), 1.5).empty());
  EXPECT_TRUE(bounds({{}, {}, {}, -1}).empty());
  EXPECT_EQ(bounds({{}, {}, {}, 1}).lo, Vec3d(-kInfinity));
}

}  // namespace quadric_test
}  // namespace pvol
