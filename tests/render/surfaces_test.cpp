// Surfaces and rays, without any light: planes, balls, solids and meshes by Embree.
#include "render/scene/surface/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pvol/error.h"
#include "pvol/math/rng.h"
#include "support/bodies.h"
#include "support/meshes.h"
#include "support/messages.h"

namespace pvol::detail {
namespace surfaces_test {

constexpr double kFar = std::numeric_limits<double>::infinity();

Vec3d random_point(Rng& rng, double reach) {
  const auto [x, y, z, w] = rng.uniform4();
  return (Vec3d(double(x), double(y), double(z)) - Vec3d(0.5)) * (2 * reach);
}

TEST(Surfaces, APlaneIsMetFromEitherSide) {
  const Surface all[] = {PlaneSurface{{0, 2, 0}, {0, 3, 0}, {}}};
  const SurfaceSet s(all, {});
  for (const double side : {1.0, -1.0}) {
    const SurfaceHit hit = s.first_hit({{5, 2 + 4 * side, 1}, {0, -side, 0}}, kFar, 0);
    ASSERT_NE(hit.material, nullptr);
    EXPECT_NEAR(hit.distance, 4, 1e-12);
    EXPECT_EQ(hit.normal, Vec3d(0, side, 0));
    EXPECT_GT((hit.place.y - 2) * side, 0) << "on the ray's side";
    EXPECT_NEAR(hit.place.y, 2, 1e-9);
    EXPECT_FALSE(s.block({hit.place, normalize(Vec3d(1, side * 0.01, 0))}, kFar, 0)) << "leaves";
    EXPECT_TRUE(s.block({hit.place, normalize(Vec3d(1, -side * 0.01, 0))}, kFar, 0)) << "enters";
  }
  EXPECT_EQ(s.first_hit({{0, 3, 0}, {1, 0, 0}}, kFar, 0).material, nullptr) << "along it";
  EXPECT_FALSE(s.block({{0, 3, 0}, {0, -1, 0}}, 0.9, 0));
  EXPECT_TRUE(s.block({{0, 3, 0}, {0, -1, 0}}, 1.1, 0));
}

/// The triangle that a ray meets first, by testing all in double.
struct Nearest {
  double t = kFar;
  double margin = kFar;  // how near a ray came to an edge, of any triangle before that
};
Nearest search(const TriangleMesh& mesh, const Affine& place, const Ray& ray) {
  Nearest nearest;
  for (const auto& triangle : mesh.triangles) {
    const Vec3d a = place.point(mesh.vertices[triangle[0]]);
    const Vec3d u = place.point(mesh.vertices[triangle[1]]) - a;
    const Vec3d v = place.point(mesh.vertices[triangle[2]]) - a;
    const Vec3d n = cross(u, v);
    const double t = dot(n, a - ray.o) / dot(n, ray.d);
    const Vec3d p = ray.at(t) - a;
    const double size = dot(n, n);
    const double x = dot(cross(p, v), n) / size, y = dot(cross(u, p), n) / size;
    const double inside = std::min({x, y, 1 - x - y});
    nearest.margin = std::min(nearest.margin, std::abs(inside));
    if (t > 0 && inside > 0) nearest.t = std::min(nearest.t, t);
  }
  return nearest;
}

TEST(Surfaces, MeshesAreMetWhereTheirTrianglesAre) {
  Rng rng(5, 0, 0);
  TriangleMesh soup;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const Vec3d at = random_point(rng, 3);
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(at + random_point(rng, 1));
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  // As it is, and far from the origin, turned and stretched: Embree's floats stand around it.
  const Affine far{{Vec3d(0, -2, 0), Vec3d(3, 0, 0.5), Vec3d(0, 0.3, 1)}, {3e6, -2e6, 1e6}};
  for (const Affine& place : {Affine{}, far}) {
    const Surface all[] = {test::mesh_surface(soup, place)};
    const SurfaceSet s(all, {});
    int hits = 0;
    for (int n = 0; n < 4000; ++n) {
      const Vec3d from = place.point(random_point(rng, 5));
      const Ray ray{from, normalize(place.point(random_point(rng, 5)) - from)};
      const Nearest expected = search(soup, place, ray);
      if (expected.margin < 1e-4) continue;
      const SurfaceHit hit = s.first_hit(ray, kFar, 0);
      ASSERT_EQ(hit.material != nullptr, expected.t < kFar) << n;
      EXPECT_EQ(s.block(ray, kFar, 0), expected.t < kFar);
      if (!hit.material) continue;
      ++hits;
      EXPECT_NEAR(hit.distance, expected.t, 1e-5 * (10 + expected.t));
      EXPECT_LT(dot(hit.normal, ray.d), 0);
      EXPECT_NEAR(length(hit.normal), 1, 1e-12);
      EXPECT_FALSE(s.block(ray, 0.999 * hit.distance - 1e-4, 0));
    }
    EXPECT_GT(hits, 500);
  }
}

TEST(Surfaces, NothingLeaksOutOfAClosedMesh) {
  const TriangleMesh ball = test::ball_mesh(24);
  const Affine place = translation({1e5, 2, -3}) * scaling({40, 1, 7});
  const Surface all[] = {test::mesh_surface(ball, place)};
  const SurfaceSet s(all, {});
  Rng rng(6, 0, 0);
  for (int n = 0; n < 100'000; ++n) {
    // Through vertices and along edges, too.
    Vec3d to = n % 2 ? ball.vertices[std::size_t(n) % ball.vertices.size()] : random_point(rng, 1);
    if (n % 4 == 1) to = 0.5 * (to + ball.vertices[std::size_t(n + 1) % ball.vertices.size()]);
    const Vec3d from = place.point(random_point(rng, 0.4));
    const Vec3d way = place.point(to * 2.0) - from;
    if (!(length(way) > 0.1)) continue;
    ASSERT_TRUE(s.block({from, normalize(way)}, kFar, 0)) << n;
  }
}

/// Of rays that leave a surface none meets it again where it is convex, and all do where hollow.
TEST(Surfaces, PlacesLieOnTheSideThatTheRayCameFrom) {
  SolidSurface solid;
  solid.body = std::make_shared<const Body>(FreeForm{unit_ball(), {}});
  solid.place.matrix = translation({700, 0, 0}) * scaling({3, 0.2, 1});
  const Surface kinds[] = {BallSurface{{0, 1e4, 5}, 2.5, {}}, solid,
                           test::mesh_surface(test::ball_mesh(24), scaling({5, 5, 0.1}))};
  const Vec3d centres[] = {{0, 1e4, 5}, {700, 0, 0}, {0, 0, 0}};
  Rng rng(7, 0, 0);
  for (std::size_t k = 0; k < std::size(kinds); ++k) {
    const SurfaceSet s({&kinds[k], 1}, {});
    int outside = 0, inside = 0;
    for (int n = 0; n < 5000; ++n) {
      const bool out = n % 2;
      const Vec3d from = centres[k] + (out ? 20.0 : 0.02) * normalize(random_point(rng, 1));
      const Vec3d to = out ? centres[k] - from + random_point(rng, 0.5) : random_point(rng, 1);
      const SurfaceHit hit = s.first_hit({from, normalize(to)}, kFar, 0);
      if (hit.material == nullptr) continue;
      Vec3d away = normalize(random_point(rng, 1));
      if (dot(away, hit.normal) < 0) away = -away;
      if (dot(away, hit.normal) < 0.01) continue;
      EXPECT_EQ(s.block({hit.place, away}, kFar, 0), !out) << kind_name(kinds[k]) << ' ' << n;
      ++(out ? outside : inside);
    }
    EXPECT_GT(outside, 300) << kind_name(kinds[k]);
    EXPECT_GT(inside, 2000) << kind_name(kinds[k]);
  }
}

/// Small things far from the origin, and far from where rays begin, do not hide themselves; nor do
/// meshes of any size.
TEST(Surfaces, FarAwayPlacesLieOutside) {
  Rng rng(8, 0, 0);
  const auto check = [&](const Surface& surface, Vec3d centre, double radius, double from) {
    const SurfaceSet s({&surface, 1}, {});
    int hits = 0;
    for (int n = 0; n < 2000; ++n) {
      const Vec3d d = normalize(random_point(rng, 1));
      const Vec3d aim = centre + random_point(rng, 0.5 * radius);
      const SurfaceHit hit = s.first_hit({aim - d * from, d}, kFar, 0);
      if (hit.material == nullptr) continue;
      Vec3d away = normalize(random_point(rng, 1));
      if (dot(away, hit.normal) < 0) away = -away;
      if (dot(away, hit.normal) < 0.05) continue;
      ++hits;
      EXPECT_FALSE(s.block({hit.place, away}, kFar, 0)) << kind_name(surface) << ' ' << radius;
      EXPECT_NEAR(length(hit.place - centre), radius, 0.02 * radius);
    }
    EXPECT_GT(hits, 1000);
  };
  check(BallSurface{{1e6, -2e6, 1e5}, 0.01, {}}, {1e6, -2e6, 1e5}, 0.01, 1);
  check(BallSurface{{0, 0, 0}, 1, {}}, {0, 0, 0}, 1, 1e8);
  for (const double size : {1e-100, 1e-12, 1e14, 1e100}) {
    check(test::mesh_surface(test::ball_mesh(32), scaling(Vec3d(size))), {0, 0, 0}, size, 5 * size);
  }
  const Vec3d far(1e7, 0, 0);
  check(test::mesh_surface(test::ball_mesh(32), translation(far)), far, 1, 10);
}

/// How far one mesh reaches does not bear on others: a plate just above the ground throws its
/// shadow, whatever lies on the horizon.
TEST(Surfaces, ALargeMeshLeavesSmallOnesTheirShadows) {
  const Surface all[] = {test::mesh_surface(test::square_mesh(5e4), translation({0, -10, 0})),
                         test::mesh_surface(test::square_mesh(1)),
                         test::mesh_surface(test::square_mesh(0.5), translation({0.1, 0.02, 0.2}))};
  const SurfaceSet s(all, {});
  const SurfaceHit hit = s.first_hit({{0.3, 0.01, 0.2}, {0, -1, 0}}, kFar, 0);
  EXPECT_NEAR(hit.place.y, 0, 1e-4);
  EXPECT_TRUE(s.block({hit.place, {0, 1, 0}}, kFar, 0));
}

TEST(Surfaces, TheNearestOfAllKindsCounts) {
  const Surface all[] = {PlaneSurface{{0, -1, 0}, {0, 1, 0}, {Rgb(0.1f)}},
                         BallSurface{{0, 5, 0}, 1, {Rgb(0.2f)}},
                         test::mesh_surface(test::ball_mesh(16), translation({0, 10, 0}))};
  const SurfaceSet s(all, {});
  const Vec3d down(0, -1, 0);
  EXPECT_EQ(s.first_hit({{0, 20, 0}, down}, kFar, 0).material->albedo, Rgb(0.5f));
  EXPECT_EQ(s.first_hit({{0, 8, 0}, down}, kFar, 0).material->albedo, Rgb(0.2f));
  EXPECT_EQ(s.first_hit({{0, 3, 0}, down}, kFar, 0).material->albedo, Rgb(0.1f));
  EXPECT_EQ(s.first_hit({{0, 3, 0}, down}, 3.9, 0).material, nullptr);
  EXPECT_EQ(s.first_hit({{0, 3, 0}, -down}, kFar, 0).material->albedo, Rgb(0.2f)) << "from within";
}

/// Two meshes, balls before and behind one another, and a plane before all: each hit has the finish
/// and the normal of what was met.
TEST(Surfaces, OfManyOfAKindTheNearestCounts) {
  const TriangleMesh aslant{{{2, -1, 0}, {-2, 1, 0}, {1, -1, 2}, {-1, 1, -2}},
                            {{0, 1, 2}, {1, 0, 3}}};
  std::vector<Surface> all{PlaneSurface{{0, -1, 0}, {0, 1, 0}, {Rgb(0.1f)}},
                           PlaneSurface{{0, -2, 0}, {0, 1, 0}, {Rgb(0.15f)}},
                           BallSurface{{0, 5, 0}, 1, {Rgb(0.2f)}},
                           BallSurface{{0, 9, 0}, 1, {Rgb(0.3f)}},
                           test::mesh_surface(test::ball_mesh(16), translation({0, 13, 0})),
                           test::mesh_surface(aslant, translation({0, 17, 0}))};
  std::get<MeshSurface>(all[4]).material.albedo = Rgb(0.4f);
  std::get<MeshSurface>(all[5]).material.albedo = Rgb(0.6f);
  const auto expect_hit = [&](double from, Vec3d way, double at, float albedo) {
    for (int order = 0; order < 2; ++order) {
      const SurfaceSet s(all, {});
      const SurfaceHit hit = s.first_hit({{1e-3, from, 1e-3}, way}, kFar, 0);
      ASSERT_NE(hit.material, nullptr) << from;
      EXPECT_EQ(hit.material->albedo, Rgb(albedo)) << from;
      EXPECT_NEAR(hit.place.y, at, 0.01) << from;
      if (albedo == 0.6f) {
        const Vec3d normal = normalize(cross(Vec3d(-4, 2, 0), Vec3d(-1, 0, 2)));
        EXPECT_NEAR(std::abs(dot(hit.normal, normal)), 1, 1e-6);
      }
      std::reverse(all.begin(), all.end());
    }
  };
  const Vec3d down(0, -1, 0);
  expect_hit(30, down, 17, 0.6f);
  expect_hit(15, down, 14, 0.4f);
  expect_hit(11, down, 10, 0.3f);
  expect_hit(7, down, 6, 0.2f);
  expect_hit(3, down, -1, 0.1f);
  expect_hit(-1.5, down, -2, 0.15f);
  expect_hit(-3, -down, -2, 0.15f);
  expect_hit(-1.5, -down, -1, 0.1f);
  expect_hit(3, -down, 4, 0.2f);
  expect_hit(7, -down, 8, 0.3f);
  expect_hit(11, -down, 12, 0.4f);
  expect_hit(15, -down, 17, 0.6f);
}

/// Across the images of a ball's tangents, whatever turns, stretches and shears it.
TEST(Surfaces, NormalsOfWhatIsStretchedStandOnIt) {
  const Affine place{{Vec3d(0, -2, 0.4), Vec3d(3, 0, 0.5), Vec3d(0.7, 0.3, 1)}, {30, -20, 10}};
  SolidSurface solid;
  solid.body = std::make_shared<const Body>(FreeForm{unit_ball(), {}});
  solid.place.matrix = place;
  const Surface kinds[] = {solid, test::mesh_surface(test::ball_mesh(64), place)};
  const double tolerance[] = {1e-6, 0.1};  // of the mesh's flat pieces
  Rng rng(8, 0, 0);
  for (std::size_t k = 0; k < std::size(kinds); ++k) {
    const SurfaceSet s({&kinds[k], 1}, {});
    for (int n = 0; n < 500; ++n) {
      const Vec3d from = place.point(3.0 * normalize(random_point(rng, 1)));
      const SurfaceHit hit = s.first_hit({from, normalize(place.t - from)}, kFar, 0);
      ASSERT_NE(hit.material, nullptr);
      const Vec3d at = inverse(place).point(hit.place);
      const Vec3d tangent = normalize(cross(at, random_point(rng, 1)));
      EXPECT_NEAR(dot(hit.normal, normalize(place.vector(tangent))), 0, tolerance[k])
          << kind_name(kinds[k]);
    }
  }
}

/// A mesh without height is met, wherever its plane lies.
TEST(Surfaces, AFlatMeshIsMet) {
  const TriangleMesh square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  Rng rng(9, 0, 0);
  for (const double z : {0.0, 0.1, -1e3 / 3, 1e7 / 7}) {
    const Surface all[] = {test::mesh_surface(square, translation({z, -z, z}))};
    const SurfaceSet s(all, {});
    for (int n = 0; n < 1000; ++n) {
      const Vec3d to = Vec3d(z, -z, z) + Vec3d(0.01 + 0.98 * double(rng.uniform()),
                                               0.01 + 0.98 * double(rng.uniform()), 0);
      const Vec3d from = to + Vec3d(0, 0, n % 2 ? 2 : -2) + random_point(rng, 1);
      const Ray ray{from, normalize(to - from)};
      const SurfaceHit hit = s.first_hit(ray, kFar, 0);
      ASSERT_NE(hit.material, nullptr) << z << ", " << n;
      EXPECT_NEAR(hit.distance, length(to - from), 1e-6) << z;
      EXPECT_TRUE(s.block(ray, kFar, 0));
    }
  }
}

void expect_refused(const Surface& surface, const std::string& key) {
  try {
    validate(surface);
    FAIL() << key;
  } catch (const Error& e) {
    EXPECT_TRUE(says(e.what(), key));
  }
}

TEST(Surfaces, ThatCannotBeAreRefused) {
  expect_refused(PlaneSurface{{0, 0, 0}, {0, 0, 0}, {}}, "surfaces.plane_normal");
  expect_refused(PlaneSurface{{0, 0, 0}, {0, 1, 0}, {Rgb(1.5f)}}, "surfaces.plane_albedo");
  expect_refused(BallSurface{{0, 0, 0}, 0, {}}, "surfaces.ball_radius");
  expect_refused(MeshSurface{}, "surfaces.mesh_no_triangles");
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}};
  expect_refused(test::mesh_surface(mesh), "surfaces.mesh_triangle_refers");
  mesh.triangles = {{0, 1, 2}};
  mesh.vertices[1].x = std::numeric_limits<double>::quiet_NaN();
  expect_refused(test::mesh_surface(mesh), "surfaces.mesh_coordinate_not_finite");
  mesh.vertices[1].x = 1;
  EXPECT_NO_THROW(validate(test::mesh_surface(mesh)));
  expect_refused(test::mesh_surface(mesh, scaling({1, 0, 1})), "surfaces.mesh_matrix_expected");
  SolidSurface solid;
  expect_refused(solid, "surfaces.solid_body_missing");
  solid.body = std::make_shared<const Body>(FreeForm{half_space({0, 0, 0}, {0, 1, 0}), {}});
  expect_refused(solid, "surfaces.solid_body_unbounded");
  const Surface beyond = test::mesh_surface(test::ball_mesh(4), scaling(Vec3d(1e308)));
  EXPECT_THROW(SurfaceSet({&beyond, 1}, {}), Error);
}

}  // namespace surfaces_test
}  // namespace pvol::detail
