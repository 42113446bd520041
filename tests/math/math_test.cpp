// Vectors, affine maps, boxes and frames, against identities and higher precision.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "math/turns.h"
#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "pvol/math/circle.h"
#include "pvol/math/nearest_word.h"
#include "pvol/math/vec.h"

namespace pvol {
namespace math_test {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kEps = std::numeric_limits<double>::epsilon();

/// Repeatable random numbers for geometry.
struct Draw {
  std::mt19937_64 engine;
  explicit Draw(std::uint64_t seed) : engine(seed) {}

  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine);
  }
  double log_uniform(double lo, double hi) {
    return std::exp2(uniform(std::log2(lo), std::log2(hi)));
  }
  Vec3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Vec3d direction() {
    for (;;) {
      const Vec3d v = vector(1);
      if (length(v) > 0.01 && length(v) < 1) return normalize(v);
    }
  }
};

Affine linear(Vec3d row0, Vec3d row1, Vec3d row2) {
  Affine a;
  a.m = {row0, row1, row2};
  return a;
}

Affine rotation(Draw& draw) {
  const Vec3d n = draw.direction();
  Vec3d s, t;
  orthonormal_basis(n, s, t);
  return linear(s, t, n);
}

Affine transpose(const Affine& a) {
  return linear({a.m[0].x, a.m[1].x, a.m[2].x}, {a.m[0].y, a.m[1].y, a.m[2].y},
                {a.m[0].z, a.m[1].z, a.m[2].z});
}

double distance(Vec3d a, Vec3d b) { return length(a - b); }

TEST(Vec3, ProductsObeyTheirIdentities) {
  Draw draw(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d a = draw.vector(2), b = draw.vector(2), c = draw.vector(2);
    EXPECT_NEAR(dot(a, cross(a, b)), 0, 1e-14);
    EXPECT_EQ(cross(a, b), -cross(b, a));
    EXPECT_NEAR(dot(a, cross(b, c)), dot(c, cross(a, b)), 1e-14);
    EXPECT_NEAR(dot(cross(a, b), cross(a, b)), dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b),
                1e-12);
    EXPECT_NEAR(length(normalize(a)), 1, 2 * kEps);
  }
  EXPECT_EQ(cross(Vec3i{1, 0, 0}, Vec3i{0, 1, 0}), (Vec3i{0, 0, 1}));
}

TEST(Vec3, ComponentsAreReachedByAxis) {
  Vec3d v{1, 2, 3};
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(v[axis], axis + 1);
  v[1] = 7;
  EXPECT_EQ(v, (Vec3d{1, 7, 3}));
  EXPECT_EQ(min_component(v), 1);
  EXPECT_EQ(max_component(v), 7);
  EXPECT_EQ(min(v, Vec3d(2)), (Vec3d{1, 2, 2}));
  EXPECT_EQ(max(v, Vec3d(2)), (Vec3d{2, 7, 3}));
  v *= Vec3d{2, 1, 0};
  v -= Vec3d{1, 1, 1};
  EXPECT_EQ(v, (Vec3d{1, 6, -1}));
  EXPECT_FALSE(is_finite(Vec3d{0, kInf, 0}));
  EXPECT_FALSE(is_finite(Vec3d{0, 0, std::nan("")}));
}

TEST(Affine, InverseUndoesTheMapAtEveryScale) {
  Draw draw(2);
  for (int i = 0; i < 3000; ++i) {
    // Voxels of 1e-9 to 1e9, sheared and rotated, every other one mirrored.
    const double size = draw.log_uniform(1e-9, 1e9);
    const Affine shear = linear({1, draw.uniform(-2, 2), draw.uniform(-2, 2)},
                                {0, 1, draw.uniform(-2, 2)}, {0, 0, i % 2 ? -1.0 : 1.0});
    const Affine a =
        translation(draw.vector(100 * size)) * rotation(draw) * shear * scaling(Vec3d(size));
    const Affine back = inverse(a);
    const Vec3d p = draw.vector(100);
    EXPECT_LT(distance(back.point(a.point(p)), p), 1e-12 * 100) << size;
    const Vec3d world = draw.vector(100 * size);
    EXPECT_LT(distance(a.point(back.point(world)), world), 1e-12 * 100 * size) << size;
    EXPECT_EQ(determinant(a) < 0, i % 2 == 1);
    EXPECT_NEAR(determinant(a) * determinant(back), 1, 1e-12);
  }
}

TEST(Affine, InverseBearsAxesOfVeryDifferentScale) {
  Draw draw(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d s{draw.log_uniform(1e-9, 1e9), draw.log_uniform(1e-9, 1e9),
                  draw.log_uniform(1e-9, 1e9)};
    const Vec3d p = draw.vector(1);
    // Column scales are voxel sizes. A point's image keeps few digits of its short axes, so the
    // product of the matrices is compared, entry by entry and by the scale of each.
    const Affine a = rotation(draw) * scaling(s);
    const Affine unit = scaling(s) * (inverse(a) * a);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        const double expected = r == c ? s[r] : 0;
        EXPECT_NEAR(unit.m[std::size_t(r)][c], expected, 1e-12 * s[c]) << r << c;
      }
    }
    // Row scales are those of world axes.
    const Affine b = scaling(s) * rotation(draw);
    EXPECT_LT(distance(inverse(b).point(b.point(p)), p), 1e-14);
  }
}

TEST(Affine, InverseOfAnExtremeScaleNeitherUnderflowsNorOverflows) {
  for (const double size : {1e-150, 1e150}) {
    const Affine back = inverse(translation(Vec3d(size)) * scaling(Vec3d(size)));
    EXPECT_LT(distance(back.point(Vec3d{4, 3, 2} * size), {3, 2, 1}), 1e-14) << size;
  }
}

TEST(Affine, InverseOfASingularMapIsNotFinite) {
  const Affine flat = inverse(scaling({1, 0, 1}));
  const Affine dependent = inverse(linear({1, 2, 4}, {2, 4, 8}, {0, 0, 1}));
  for (const Affine& a : {flat, dependent}) {
    EXPECT_FALSE(is_finite(a.m[0]) && is_finite(a.m[1]) && is_finite(a.m[2]));
  }
}

TEST(Affine, ProductAppliesTheRightFactorFirst) {
  Draw draw(4);
  EXPECT_EQ((translation({1, 0, 0}) * scaling(Vec3d(2.0))).point({1, 1, 1}), (Vec3d{3, 2, 2}));
  EXPECT_EQ((scaling(Vec3d(2.0)) * translation({1, 0, 0})).point({1, 1, 1}), (Vec3d{4, 2, 2}));
  for (int i = 0; i < 1000; ++i) {
    const Affine a = translation(draw.vector(3)) * rotation(draw);
    const Affine b = scaling(draw.vector(2)) * translation(draw.vector(3));
    const Vec3d p = draw.vector(1);
    EXPECT_LT(distance((a * b).point(p), a.point(b.point(p))), 1e-13);
    EXPECT_LT(distance((a * b).vector(p), a.vector(b.vector(p))), 1e-13);
    EXPECT_NEAR(determinant(a * b), determinant(a) * determinant(b), 1e-12);
  }
}

TEST(Affine, NormalsTurnByTheTransposedInverseAndFlipInAMirror) {
  Draw draw(5);
  for (int i = 0; i < 1000; ++i) {
    const double mirror = i % 2 ? -1 : 1;
    const Affine a = rotation(draw) * linear({mirror, 0.5, 0}, {0, 2, -0.3}, {0, 0, 0.7});
    const Vec3d u = draw.direction(), v = draw.direction();
    // (A u) x (A v) = det(A) A^-T (u x v): a surface's winding turns round where det < 0.
    const Vec3d turned = transpose(inverse(a)).vector(cross(u, v)) * determinant(a);
    EXPECT_LT(distance(cross(a.vector(u), a.vector(v)), turned), 1e-13);
    EXPECT_EQ(std::signbit(determinant(a)), i % 2 == 1);
  }
}

const Box kUnitBox{Vec3d(0), Vec3d(1)};

TEST(Box, IsEmptyByDefaultAndNoRayMeetsAnEmptyOne) {
  const Box empty;
  EXPECT_TRUE(empty.empty());
  EXPECT_FALSE(empty.contains(Vec3d(0)));
  EXPECT_EQ(extend(empty, {1, 2, 3}), (Box{{1, 2, 3}, {1, 2, 3}}));
  Draw draw(6);
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(transform(rotation(draw), empty).empty());
    EXPECT_FALSE(intersect(empty, {draw.vector(1), draw.direction()}, 0, kInf));
    EXPECT_FALSE(intersect({{0, 0, 1}, {1, 1, 0}}, {{0.5, 0.5, -1}, draw.direction()}, 0, kInf));
  }
  EXPECT_FALSE(intersect(empty, {Vec3d(0), {0, 0, 1}}, 0, kInf));
}

TEST(Box, TransformHoldsTheImageOfEveryPointTightly) {
  Draw draw(7);
  for (int i = 0; i < 200; ++i) {
    const Affine a = translation(draw.vector(5)) * rotation(draw) * scaling(draw.vector(3));
    const Box image = transform(a, kUnitBox);
    const Box grown{image.lo - Vec3d(1e-13), image.hi + Vec3d(1e-13)};
    Box seen;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p{double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)};
      seen = extend(seen, a.point(p));
    }
    EXPECT_EQ(seen, image);
    for (int k = 0; k < 50; ++k) {
      EXPECT_TRUE(grown.contains(a.point((draw.vector(1) + Vec3d(1)) * 0.5)));
    }
  }
}

/// The same by the definition: every slab on its own, in long double.
std::optional<Span> slow_intersect(const Box& b, const Ray& r, double t0, double t1) {
  long double lo = t0, hi = t1;
  for (int axis = 0; axis < 3; ++axis) {
    const long double o = r.o[axis], d = r.d[axis];
    if (d == 0 && !(o >= b.lo[axis] && o <= b.hi[axis])) return std::nullopt;
    if (d == 0) continue;
    const long double a = (b.lo[axis] - o) / d, c = (b.hi[axis] - o) / d;
    lo = std::max(lo, std::min(a, c));
    hi = std::min(hi, std::max(a, c));
  }
  if (!(lo < hi)) return std::nullopt;
  return Span{double(lo), double(hi)};
}

TEST(Box, SpanAgreesWithHigherPrecisionForRandomAndAxisParallelRays) {
  Draw draw(8);
  const double zeros[] = {0.0, -0.0};
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    Ray r{draw.vector(2), draw.direction()};
    if (i % 2) r.d = draw.vector(0.3) - r.o;
    r.d *= draw.log_uniform(1e-6, 1e6);
    for (int axis = 0; axis < 3; ++axis) {
      if (draw.uniform(0, 1) < 0.3) r.d[axis] = zeros[i % 2];
    }
    const Box b{min(draw.vector(1), Vec3d(0)), Vec3d(draw.uniform(0.1, 1))};
    const auto expected = slow_intersect(b, r, 0, kInf), found = intersect(b, r, 0, kInf);
    if (expected && expected->t1 - expected->t0 < 1e-12 * expected->t1) continue;
    ASSERT_EQ(bool(expected), bool(found)) << i;
    if (!found || found->t1 == kInf) continue;
    ++hits;
    EXPECT_NEAR(found->t0, expected->t0, 1e-14 * expected->t1);
    EXPECT_NEAR(found->t1, expected->t1, 1e-14 * expected->t1);
  }
  EXPECT_GT(hits, 3000);
}

TEST(Box, ParallelRaysCountWhereTheirOriginLiesInTheClosedSlab) {
  for (const double zero : {0.0, -0.0}) {
    for (const double side : {0.0, -0.0, 0.5, 1.0}) {
      for (const double sign : {1.0, -1.0}) {
        const auto s = intersect(kUnitBox, {{0.5 - sign, side, 1}, {sign, zero, zero}}, 0, kInf);
        ASSERT_TRUE(s) << zero << " " << side << " " << sign;
        EXPECT_EQ(s->t0, 0.5);
        EXPECT_EQ(s->t1, 1.5);
      }
    }
    for (const double side : {std::nextafter(0.0, -1.0), std::nextafter(1.0, 2.0)}) {
      EXPECT_FALSE(intersect(kUnitBox, {{-1, side, 0.5}, {1, zero, zero}}, 0, kInf));
    }
  }
}

TEST(Box, RaysThroughCornersAndEdgesOfTheInsideAreHitExactly) {
  const auto diagonal = intersect(kUnitBox, {Vec3d(-1), Vec3d(1)}, 0, kInf);
  ASSERT_TRUE(diagonal);
  EXPECT_EQ(diagonal->t0, 1);
  EXPECT_EQ(diagonal->t1, 2);
  const auto from_edge_to_edge = intersect(kUnitBox, {{-1, 2, 0.5}, {1, -1, 0}}, 0, kInf);
  ASSERT_TRUE(from_edge_to_edge);
  EXPECT_EQ(from_edge_to_edge->t0, 1);
  EXPECT_EQ(from_edge_to_edge->t1, 2);
}

TEST(Box, ATouchInOnePointIsNoSpan) {
  EXPECT_FALSE(intersect(kUnitBox, {{-1, 1, 0}, {1, 1, 1}}, 0, kInf)) << "beside an edge";
  EXPECT_FALSE(intersect(kUnitBox, {{1, -1, 0.5}, {1, 1, 0}}, 0, kInf)) << "at an edge";
  EXPECT_FALSE(intersect(kUnitBox, {{1, 0.5, 0.5}, {1, 0, 0}}, 0, kInf)) << "leaving a face";
  EXPECT_FALSE(intersect(kUnitBox, {{-1, 0.5, 0.5}, {1, 0, 0}}, 0, 1)) << "ends on a face";
}

TEST(Box, OriginsInsideStartAtTheGivenDistance) {
  const auto s = intersect(kUnitBox, {Vec3d(0.5), {0, 0, 2}}, 0, kInf);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->t0, 0);
  EXPECT_EQ(s->t1, 0.25);
  const auto part = intersect(kUnitBox, {{-1, 0.5, 0.5}, {1, 0, 0}}, 1.25, 1.5);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->t0, 1.25);
  EXPECT_EQ(part->t1, 1.5);
  EXPECT_FALSE(intersect(kUnitBox, {{2, 0.5, 0.5}, {1, 0, 0}}, 0, kInf)) << "behind the origin";
}

TEST(Box, FarOriginsKeepTheAccuracyOfTheirCoordinates) {
  Draw draw(9);
  for (int i = 0; i < 2000; ++i) {
    const Vec3d target = (draw.vector(0.8) + Vec3d(1)) * 0.5;
    const double distance = draw.log_uniform(1, 1e9);  // beyond, ulps of the aim matter
    const Vec3d origin = target - draw.direction() * distance;
    const Ray r{origin, normalize(target - origin)};
    const auto s = intersect(kUnitBox, r, 0, kInf), exact = slow_intersect(kUnitBox, r, 0, kInf);
    ASSERT_TRUE(s && exact) << distance;
    const double least = std::min({std::abs(r.d.x), std::abs(r.d.y), std::abs(r.d.z)});
    const double rounding = 8 * kEps * (distance + 1) / least;
    EXPECT_NEAR(s->t0, exact->t0, rounding);
    EXPECT_NEAR(s->t1, exact->t1, rounding);
  }
}

TEST(Box, DirectionsTooSmallToDivideByStillGiveAnAnswer) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  const auto s = intersect(kUnitBox, {{-1, 0.5, 0.5}, {1, tiny, -tiny}}, 0, kInf);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->t0, 1);
  EXPECT_EQ(s->t1, 2);
  const auto on_face = intersect(kUnitBox, {{-1, 0, 1}, {1, tiny, -tiny}}, 0, kInf);
  ASSERT_TRUE(on_face);
  EXPECT_EQ(on_face->t1, 2);
  EXPECT_FALSE(intersect(kUnitBox, {{-1, 2, 0.5}, {1, tiny, 0}}, 0, kInf));
}

/// Largest departure of (s, t, n) from a right-handed orthonormal frame.
template <class T>
T frame_error(Vec3<T> n) {
  Vec3<T> s, t;
  orthonormal_basis(n, s, t);
  const Vec3<T> handed = cross(s, t) - n;
  return std::max({std::abs(dot(s, n)), std::abs(dot(t, n)), std::abs(dot(s, t)),
                   std::abs(dot(s, s) - 1), std::abs(dot(t, t) - 1), length(handed)});
}

TEST(OrthonormalBasis, IsRightHandedForEveryDirection) {
  Draw draw(13);
  for (int i = 0; i < 20'000; ++i) {
    Vec3d n = draw.direction();
    // A third close to the poles, where the formula divides by 1 + |z|; a third to the equator.
    if (i % 3 == 1) n = normalize(n * Vec3d{1e-6, 1e-6, 1});
    if (i % 3 == 2) n = normalize(n * Vec3d{1, 1, 1e-12});
    EXPECT_LT(frame_error(n), 1e-15);
    EXPECT_LT(frame_error(normalize(Vec3f(n))), 6e-7f);
  }
}

TEST(OrthonormalBasis, IsExactAlongTheAxesWithEitherZero) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      for (const double zero : {0.0, -0.0}) {
        Vec3d n(zero);
        n[axis] = sign;
        EXPECT_EQ(frame_error(n), 0) << axis << " " << sign << " " << zero;
        EXPECT_EQ(frame_error(Vec3f(n)), 0) << axis << " " << sign << " " << zero;
      }
    }
  }
}

TEST(Luminance, OfWhiteIsOne) {
  EXPECT_NEAR(luminance(Rgb(1.0f)), 1, 1e-7);
  EXPECT_DOUBLE_EQ(luminance(Vec3d(1, 10, 100)), 0.2126 + 7.152 + 7.22);
  EXPECT_GT(luminance(Rgb(0, 1, 0)), luminance(Rgb(1, 0, 0)));
  EXPECT_GT(luminance(Rgb(1, 0, 0)), luminance(Rgb(0, 0, 1)));
}

TEST(Circle, PointsLieWithinTheStatedError) {
  double worst = 0;
  for (int i = 0; i <= 1'000'000; ++i) {
    const float u = float(i) * 1e-6f;
    const double angle = 2 * std::numbers::pi * double(u);
    const CirclePoint p = point_at_turns(u);
    worst = std::max({worst, std::abs(double(p.cosine) - std::cos(angle)),
                      std::abs(double(p.sine) - std::sin(angle))});
  }
  EXPECT_LT(worst, 2e-7);
}

TEST(Circle, AnglesLieWithinTheStatedError) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1, 1);
  double worst = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    float x = uniform(random), y = uniform(random);
    if (i % 3 == 0) x = std::ldexp(x, -i % 60);
    if (i % 5 == 0) y = std::ldexp(y, -i % 60);
    const double exact = std::atan2(double(y), double(x)) / (2 * std::numbers::pi);
    worst = std::max(worst, std::abs(double(turns_of(y, x)) - exact));
  }
  EXPECT_LT(worst, 1e-7);
  EXPECT_EQ(turns_of(0, 0), 0);
  EXPECT_EQ(turns_of(1, 0), 0.25f);
  EXPECT_EQ(turns_of(-1, 0), -0.25f);
  EXPECT_EQ(turns_of(0, -1), 0.5f);
  EXPECT_EQ(turns_of(-0.0f, -1), -0.5f);
}

TEST(NearestWord, TakesFewEdits) {
  const std::string_view words[] = {"fov", "frames", "frame", "exposure"};
  const auto nearest = [&](std::string_view found) { return nearest_word(found, words); };
  EXPECT_EQ(nearest("exposur"), "exposure");
  EXPECT_EQ(nearest("xposuer"), std::nullopt);  // three
  EXPECT_EQ(nearest("expsoure"), "exposure");   // a pair in the wrong order counts twice
  EXPECT_EQ(nearest("frams"), "frames");        // the first of two as near
  EXPECT_EQ(nearest("fo"), "fov");
  EXPECT_EQ(nearest("fx"), std::nullopt);  // more than half of it
  EXPECT_EQ(nearest("frame"), "frame");
  EXPECT_EQ(nearest(""), std::nullopt);
  EXPECT_EQ(nearest_word("fov", {}), std::nullopt);
}

}  // namespace math_test
}  // namespace pvol
