// Values and moments over many points, by loops for each instruction set.
#include "shell/fit/monomials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "pvol/math/rng.h"

namespace pvol::test {
namespace monomials_test {

using namespace pvol::detail;

const Quadric kQuadric{{-1, 0.5, -2}, {0.3, -0.7, 0.2}, {0.4, -0.1, 0.6}, 0.25};

Points some_points(std::size_t count) {
  Points points;
  Rng rng(1, 2, 3);
  for (std::size_t i = 0; i < count; ++i) {
    const auto [x, y, z, w] = rng.uniform4();
    points.add(Vec3f(x, y, z) * 2.0f - Vec3f(1.0f));
  }
  return points;
}

/// Sums of weight(value) times the monomials, in doubles.
QuadricTerms sums(const Points& points, const std::function<double(double)>& weight) {
  QuadricTerms sum{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d p(points[i]);
    const double w = weight(value(kQuadric, p));
    const double of[] = {p.x * p.x, p.y * p.y, p.z * p.z, p.y * p.z, p.z * p.x,
                         p.x * p.y, p.x,       p.y,       p.z,       1};
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += w * of[k];
  }
  return sum;
}

void expect_near(const QuadricTerms& found, const QuadricTerms& expected) {
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_NEAR(found[k], expected[k], 2e-5 * std::abs(expected[9])) << "monomial " << k;
  }
}

TEST(PointLoops, FindValuesAndTheGreatest) {
  const Monomials q = monomials(kQuadric);
  for (const PointLoops& loops : point_loops()) {
    for (const std::size_t count : {0, 1, 7, 8, 61, 400}) {
      const Points points = some_points(count);
      std::vector<float> values(count);
      double most = -INFINITY;
      const float greatest = loops.evaluate(q, points, values.data());
      for (std::size_t i = 0; i < count; ++i) {
        const double exact = value(kQuadric, Vec3d(points[i]));
        EXPECT_NEAR(double(values[i]), exact, 2e-6);
        most = std::max(most, double(values[i]));
      }
      EXPECT_EQ(double(greatest), most) << count << " points";
    }
  }
}

TEST(PointLoops, FindMoments) {
  const Monomials q = monomials(kQuadric);
  const Points points = some_points(800);
  std::vector<float> values(points.size());
  const double most = double(evaluate(q, points, values.data()));
  constexpr double kReach = 0.5, kWidth = 0.3;
  const auto near = [&](double v) { return std::pow(std::max(0.0, 1 - (most - v) / kReach), 4); };
  const auto slope = [&](double v) { return std::pow(1 + std::pow((v - most) / kWidth, 2), -1.5); };
  EXPECT_GT(sums(points, near)[9], 1) << "some points are near";
  for (const PointLoops& loops : point_loops()) {
    expect_near(loops.moments(points, values.data()), sums(points, [](double v) { return v; }));
    expect_near(loops.moments_near(points, values.data(), float(most), float(1 / kReach)),
                sums(points, near));
    expect_near(loops.moments_of_slopes(q, points, float(most), float(1 / kWidth)),
                sums(points, slope));
  }
}

TEST(Monomials, TellTheMeanSquareGradient) {
  const Points points = some_points(64);
  const auto weight = [](double v) { return 1 + 0.5 * v; };
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d p(points[i]), g = gradient(kQuadric, p);
    const double w = weight(value(kQuadric, p));
    sum += w * dot(g, g), weights += w;
  }
  const double expected = sum / weights;
  EXPECT_NEAR(mean_square_gradient(kQuadric, sums(points, weight)), expected, 1e-12 * expected);
}

/// A file that is made anew on another machine has the same shell.
TEST(PointLoops, OfEveryInstructionSetFindTheSameBits) {
  const Monomials q = monomials(kQuadric);
  const Points points = some_points(800);
  std::vector<float> expected(points.size()), values(points.size());
  const std::vector<PointLoops> all = point_loops();
  if (all.size() < 2) GTEST_SKIP() << "the processor has no AVX2";
  const PointLoops& first = all.front();
  const float most = first.evaluate(q, points, expected.data());
  for (const PointLoops& loops : all) {
    EXPECT_EQ(loops.evaluate(q, points, values.data()), most);
    EXPECT_EQ(values, expected);
    EXPECT_EQ(loops.moments(points, values.data()), first.moments(points, values.data()));
    EXPECT_EQ(loops.moments_near(points, values.data(), most, 2),
              first.moments_near(points, values.data(), most, 2));
    EXPECT_EQ(loops.moments_of_slopes(q, points, most, 3),
              first.moments_of_slopes(q, points, most, 3));
  }
}

}  // namespace monomials_test
}  // namespace pvol::test
