// Rays against free forms and trees of them: the first root is the one that the value tells.
#include "pvol/form/ray_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pvol/error.h"
#include "pvol/form/roots.h"
#include "pvol/math/rng.h"

namespace pvol {
namespace ray_body_test {

double uniform(Rng& rng, double lo, double hi) { return lo + (hi - lo) * double(rng.uniform()); }

Vec3d random_point(Rng& rng, double reach) {
  return {uniform(rng, -reach, reach), uniform(rng, -reach, reach), uniform(rng, -reach, reach)};
}

/// (s - r0)(s - r1)... times a factor.
Quartic product(const std::vector<double>& roots, double factor) {
  Quartic c{factor};
  for (std::size_t n = 0; n < roots.size(); ++n) {
    for (std::size_t i = n + 2; i-- > 1;) c[i] = c[i - 1] - roots[n] * c[i];
    c[0] *= -roots[n];
  }
  return c;
}

TEST(Roots, OfProductsAreTheirFactors) {
  Rng rng(1, 0, 0);
  for (int n = 0; n < 20'000; ++n) {
    std::vector<double> roots, inside;
    const int degree = 1 + n % 4;
    for (int k = 0; k < degree; ++k) roots.push_back(uniform(rng, -1, 2));
    std::sort(roots.begin(), roots.end());
    double gap = 1;
    for (std::size_t k = 1; k < roots.size(); ++k) gap = std::min(gap, roots[k] - roots[k - 1]);
    if (gap < 1e-3) continue;
    for (const double r : roots) {
      if (r > 0 && r < 1) inside.push_back(r);
    }
    const Roots found = sign_changes(product(roots, uniform(rng, 0.1, 5)), 0, 1);
    ASSERT_EQ(std::size_t(found.count), inside.size()) << n;
    for (std::size_t k = 0; k < inside.size(); ++k) EXPECT_NEAR(found.at[k], inside[k], 1e-9);
  }
}

/// Leading coefficients that hardly count: a slope's roots lie where they would be without them.
TEST(Roots, OfTinyLeadingCoefficientsAreThoseWithout) {
  for (const double sign : {1.0, -1.0}) {
    for (const double tiny : {1e-17, -1e-17, 1e-30, -1e-300}) {
      for (const std::size_t degree : {3u, 4u}) {
        Quartic c = product({0.25, 0.75}, sign);
        c[degree] = tiny;
        const Roots found = sign_changes(c, 0, 1);
        ASSERT_EQ(found.count, 2) << sign << ", " << tiny << " s^" << degree;
        EXPECT_NEAR(found.at[0], 0.25, 1e-12);
        EXPECT_NEAR(found.at[1], 0.75, 1e-12);
      }
    }
  }
}

TEST(Roots, WhereTheSignStaysThereIsNone) {
  EXPECT_EQ(sign_changes(product({0.5, 0.5}, 1), 0, 1).count, 0) << "it touches";
  EXPECT_EQ(sign_changes({1, 0, 0, 0, 0}, 0, 1).count, 0);
  EXPECT_EQ(sign_changes({0, 0, 0, 0, 0}, 0, 1).count, 0);
  EXPECT_EQ(sign_changes(product({0.25, 0.25, 0.75, 0.75}, -1), 0, 1).count, 0);
  const Roots triple = sign_changes(product({0.5, 0.5, 0.5}, 1), 0, 1);
  ASSERT_EQ(triple.count, 1) << "it touches and passes";
  EXPECT_NEAR(triple.at[0], 0.5, 1e-4);
  const Roots halves = sign_changes(product({0.5}, 1), 0, 1);
  ASSERT_EQ(halves.count, 1);
  EXPECT_EQ(halves.at[0], 0.5);
}

FreeForm ball(Vec3d centre, double radius) { return {ellipsoid(centre, Vec3d(radius)), {}}; }

TEST(RayBody, BallsAreMetWhereTheirEquationSays) {
  const RayBody body(Body(ball({1, 2, 3}, 2)));
  Rng rng(2, 0, 0);
  int hits = 0;
  for (int n = 0; n < 10'000; ++n) {
    const Vec3d o = random_point(rng, 9), d = normalize(random_point(rng, 5) - o);
    const Vec3d to = Vec3d(1, 2, 3) - o;
    const double along = dot(to, d), square = 4 - dot(to, to) + along * along;
    const bool within = dot(to, to) < 4;
    const auto hit = body.first_hit({o, d}, 0, 1e9);
    if (std::abs(square) < 1e-6) continue;
    const double t = within ? along + std::sqrt(square) : along - std::sqrt(square);
    ASSERT_EQ(hit.has_value(), square > 0 && t > 0) << n;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->t, t, 1e-10);
    const Vec3d out = (o + d * t - Vec3d(1, 2, 3)) / 2;
    EXPECT_NEAR(dot(normalize(hit->normal), out), -1, 1e-9) << "values rise inwards";
  }
  EXPECT_GT(hits, 1000);
}

FreeForm random_form(Rng& rng) {
  FreeForm form = ball(random_point(rng, 1), uniform(rng, 0.7, 1.5));
  const int bends = int(uniform(rng, 0, 5));
  for (int k = 0; k < bends; ++k) {
    const double strength = uniform(rng, -2, 2);
    form.perturbations.push_back({ball(random_point(rng, 1.5), uniform(rng, 0.3, 1)), strength});
  }
  return form;
}

Body random_body(Rng& rng, int depth) {
  if (depth == 0 || rng.uniform() < 0.3f) return Body(random_form(rng));
  const BodyOp ops[] = {BodyOp::join, BodyOp::intersection, BodyOp::difference};
  std::vector<Body> parts;
  for (int k = 0; k < 3; ++k) parts.push_back(random_body(rng, depth - 1));
  return {ops[int(uniform(rng, 0, 2.999))], parts};
}

/// Through what lies around the origin.
Ray random_ray(Rng& rng) {
  const Vec3d from = random_point(rng, 4);
  return {from, normalize(random_point(rng, 1.5) - from)};
}

/// The value on this side of the hit has one sign at every step, and the other one behind it.
void expect_first(const Body& body, const RayBody& ready, const Ray& ray, double t1) {
  const auto hit = ready.first_hit(ray, 0, t1);
  constexpr int kSteps = 400;
  const double end = hit ? hit->t : t1;
  const bool inside = value(body, ray.at(1e-9 * t1)) >= 0;
  for (int i = 1; i < kSteps; ++i) {
    const double t = end * i / kSteps, v = value(body, ray.at(t));
    if (std::abs(v) < 1e-9) continue;
    ASSERT_EQ(v >= 0, inside) << t << " before " << end;
  }
  if (!hit) return;
  EXPECT_NEAR(value(body, ray.at(hit->t)), 0, 1e-9);
}

TEST(RayBody, FindsWhereTheValueOfTreesPassesZero) {
  Rng rng(3, 0, 0);
  int hits = 0, bodies = 0;
  for (int n = 0; n < 400; ++n) {
    const Body body = random_body(rng, n % 3);
    const Box box = bounds(body);
    if (box.empty() || !is_finite(box.extent())) continue;
    ++bodies;
    const RayBody ready(body);
    for (int k = 0; k < 50; ++k) {
      const Ray ray = random_ray(rng);
      ASSERT_NO_FATAL_FAILURE(expect_first(body, ready, ray, 12)) << "body " << n << " ray " << k;
      hits += ready.first_hit(ray, 0, 12).has_value();
    }
  }
  EXPECT_GT(bodies, 300);
  EXPECT_GT(hits, 2000);
}

TEST(RayBody, NormalsAreThoseOfTheValue) {
  Rng rng(4, 0, 0);
  int hits = 0;
  for (int n = 0; n < 200; ++n) {
    const Body body = random_body(rng, 1);
    const RayBody ready(body);
    const Ray ray = random_ray(rng);
    const auto hit = ready.first_hit(ray, 0, 12);
    if (!hit) continue;
    const Vec3d p = ray.at(hit->t);
    Vec3d slope;
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d step;
      step[axis] = kStep;
      slope[axis] = (value(body, p + step) - value(body, p - step)) / (2 * kStep);
    }
    const Vec3d normal = normalize(hit->normal);
    // At a crease, and of what is cut out, the sign is the other one: rays turn it anyway.
    EXPECT_NEAR(std::abs(dot(normal, normalize(slope))), 1, 1e-4) << n;
    ++hits;
  }
  EXPECT_GT(hits, 60);
}

TEST(RayBody, StaysWithinItsLimits) {
  const RayBody body(Body(ball({0, 0, 0}, 1)));
  const Ray ray{{-5, 0, 0}, {1, 0, 0}};
  EXPECT_FALSE(body.first_hit(ray, 0, 3.9));
  EXPECT_NEAR(body.first_hit(ray, 0, 4.1)->t, 4, 1e-12);
  EXPECT_NEAR(body.first_hit(ray, 4.5, 9)->t, 6, 1e-12);
  EXPECT_FALSE(body.first_hit(ray, 6.1, 9));
  EXPECT_FALSE(body.first_hit({{-5, 2, 0}, {1, 0, 0}}, 0, 99));
}

TEST(RayBody, RefusesWhatHasNoEndOrNoClosedForm) {
  EXPECT_THROW(RayBody(Body(FreeForm{half_space({0, 0, 0}, {0, 1, 0}), {}})), Error);
  FreeForm nested = ball({0, 0, 0}, 1);
  nested.perturbations.push_back({ball({0, 1, 0}, 0.5), 1});
  nested.perturbations.front().form.perturbations.push_back({ball({0, 1.2, 0}, 0.2), 1});
  EXPECT_THROW((RayBody(Body(nested))), Error);
}

}  // namespace ray_body_test
}  // namespace pvol
