#include "pvol/shell/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "pvol/error.h"

namespace pvol {
namespace mesh_test {

constexpr double kPi = std::numbers::pi;

Quadric ball(Vec3d centre, double radius) {
  return {Vec3d(-1), {}, 2.0 * centre, radius * radius - dot(centre, centre)};
}

/// A shell whose frame is [-1, 1]^3 over 64^3 cells far from the origin.
Shell shell_of(ShellKind kind, FreeForm form) {
  Shell s;
  s.kind = kind;
  s.lo = {1000, -2000, 3000};
  s.hi = s.lo + Vec3l(64);
  s.form = round_to_float(form);
  return s;
}
Shell ball_shell() { return shell_of(ShellKind::hard, {ball({}, 0.9), {}}); }

/// A ball with a cylinder of this radius drilled through along z: a solid torus.
Shell ring_shell(double radius) {
  const Quadric cylinder{{-1, -1, 0}, {}, {}, radius * radius};
  return shell_of(ShellKind::hard, {ball({}, 0.9), {{{cylinder, {}}, -1}}});
}

struct Topology {
  bool closed = true;  ///< each edge in two triangles, in opposite directions
  int euler = 0;
};

Topology topology(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  Topology result;
  result.closed = std::adjacent_find(edges.begin(), edges.end()) == edges.end();
  std::vector<bool> used(mesh.vertices.size());
  for (const auto& [a, b] : edges) {
    used[a] = true;
    if (!std::binary_search(edges.begin(), edges.end(), std::pair(b, a))) result.closed = false;
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
  result.euler = int(used.size()) - int(edges.size() / 2) + int(mesh.triangles.size());
  return result;
}

double least_area(const TriangleMesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.vertices[t[0]];
    const Vec3d n = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
    least = std::min(least, length(n) / 2);
  }
  return least;
}

TEST(ShellMesh, BallIsASphere) {
  for (const int resolution : {8, 17, 64}) {
    const TriangleMesh mesh = make_mesh(ball_shell(), resolution);
    const Topology t = topology(mesh);
    EXPECT_TRUE(t.closed) << resolution;
    EXPECT_EQ(t.euler, 2) << resolution;
    EXPECT_GT(least_area(mesh), 0) << resolution;
  }
}

TEST(ShellMesh, HoleThroughAHardShellMakesATorus) {
  const TriangleMesh mesh = make_mesh(ring_shell(0.4), 96);
  const Topology t = topology(mesh);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.euler, 0);
}

TEST(ShellMesh, HollowBoxHasTwoSurfaces) {
  const Shell hollow = shell_of(ShellKind::hard, {{{}, {}, {}, 1}, {{{ball({}, 0.5), {}}, -1}}});
  const TriangleMesh mesh = make_mesh(hollow, 64);
  const Topology t = topology(mesh);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.euler, 4);
  const double exact = 64 * 64 * 64 - 4 * kPi / 3 * 16 * 16 * 16;
  EXPECT_NEAR(volume(mesh), exact, 0.003 * exact);
}

TEST(ShellMesh, VolumeTendsToTheClosedFormWithTheSquareOfTheStep) {
  // Outward orientation is in the sign. What is left of a ball of radius R with a hole of radius r
  // is 4/3 pi (R^2 - r^2)^(3/2).
  const double unit = 32 * 32 * 32;
  const auto check = [&](const Shell& shell, double exact) {
    double last = 1;
    for (const int resolution : {16, 32, 64, 128}) {
      const double error = std::abs(volume(make_mesh(shell, resolution)) / (exact * unit) - 1);
      EXPECT_LT(error, 0.1 * std::pow(16.0 / resolution, 2)) << resolution;
      EXPECT_LT(error, 0.45 * last) << resolution;
      last = error;
    }
  };
  check(ball_shell(), 4 * kPi / 3 * std::pow(0.9, 3));
  check(ring_shell(0.4), 4 * kPi / 3 * std::pow(0.81 - 0.16, 1.5));
}

TEST(ShellMesh, VerticesLieOnTheSurface) {
  const Shell shell = ring_shell(0.4);
  const ShellFrame f = frame(shell);
  const int resolution = 48;
  const double tolerance = 64.0 / resolution / 1000;
  for (const Vec3d v : make_mesh(shell, resolution).vertices) {
    const Vec3d p = f.to_shell(v);
    const double to_ball = std::abs(length(p) - 0.9) * f.unit;
    const double to_hole = std::abs(std::hypot(p.x, p.y) - 0.4) * f.unit;
    ASSERT_LE(std::min(to_ball, to_hole), tolerance);
  }
}

TEST(ShellMesh, FacesOfTheBoxBelongToTheSurface) {
  Shell box = shell_of(ShellKind::soft, {{{}, {}, {}, 1}, {}});
  box.hi = box.lo + Vec3l(1000, 700, 1);  // thinner than a step of the longest side
  const TriangleMesh mesh = make_mesh(box, 100);
  const Topology t = topology(mesh);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.euler, 2);
  EXPECT_NEAR(volume(mesh), 700000, 0.05 * 700000);  // the edges are cut off, as in any such mesh
  Box around;
  for (const Vec3d v : mesh.vertices) around = extend(around, v);
  EXPECT_LE(length(around.lo - Vec3d(box.lo)), 0.01);
  EXPECT_LE(length(around.hi - Vec3d(box.hi)), 0.01);
}

TEST(ShellMesh, AnyShellIsClosedAndHasTheVolumeThatPointsTell) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
  for (int n = 0; n < 8; ++n) {
    const ShellKind kind = n % 2 ? ShellKind::soft : ShellKind::hard;
    FreeForm form{ball(0.2 * point(), 0.8), {}};
    for (int i = 0; i < 6; ++i) {
      Quadric q = ball(point(), 0.3 + 0.2 * std::abs(uniform(random)));
      q.square += 0.5 * point();
      q.mixed += 0.5 * point();
      const double sign = i % 3 ? -1 : 1;
      form.perturbations.push_back({{q, {}}, kind == ShellKind::hard ? sign : 20 * sign});
    }
    const Shell shell = shell_of(kind, form);
    const TriangleMesh mesh = make_mesh(shell, 64);
    EXPECT_TRUE(topology(mesh).closed) << n;
    EXPECT_GT(least_area(mesh), 0) << n;
    int inside = 0;
    const int samples = 200000;
    for (int i = 0; i < samples; ++i) {
      const Vec3d half(32);
      inside += contains(shell, Vec3d(shell.lo) + half + half * point());
    }
    const double estimate = 64.0 * 64 * 64 * inside / samples;
    EXPECT_NEAR(volume(mesh), estimate, 64.0 * 64 * 64 * 0.006) << n;
  }
}

TEST(ShellMesh, NothingInsideIsAnEmptyMesh) {
  const TriangleMesh mesh = make_mesh(shell_of(ShellKind::hard, {{{}, {}, {}, -1}, {}}), 9);
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_EQ(volume(mesh), 0);
}

TEST(ShellMesh, RefusesResolutionsOutOfRange) {
  EXPECT_THROW((void)make_mesh(ball_shell(), 7), Error);
  EXPECT_THROW((void)make_mesh(ball_shell(), 1025), Error);
}

TEST(SupportMesh, OneCellIsACube) {
  const TriangleMesh mesh = make_mesh(make_support({{-5, 7, 1000000}}));
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_TRUE(topology(mesh).closed);
  EXPECT_EQ(volume(mesh), 1);
  Box around;
  for (const Vec3d v : mesh.vertices) around = extend(around, v);
  EXPECT_EQ(around, (Box{{-5, 7, 1000000}, {-4, 8, 1000001}}));
}

TEST(SupportMesh, BallOfCellsIsClosedAndHasItsVolume) {
  // Full blocks of several sizes inside, a cavity of one cell, blocks with masks around.
  std::vector<Vec3l> cells;
  for (int x = -40; x < 40; ++x) {
    for (int y = -40; y < 40; ++y) {
      for (int z = -40; z < 40; ++z) {
        const Vec3d centre{x + 0.5, y + 0.5, z + 0.5};
        if (length(centre) < 39.3 && length(centre - Vec3d(20.5)) > 0.5) cells.push_back({x, y, z});
      }
    }
  }
  const Support support = make_support(cells);
  ASSERT_GT(std::max_element(support.blocks.begin(), support.blocks.end(),
                             [](auto& a, auto& b) { return a.level < b.level; })
                ->level,
            0u);
  const TriangleMesh mesh = make_mesh(support);
  const Topology t = topology(mesh);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.euler, 4);
  EXPECT_EQ(volume(mesh), double(cells.size()));
}

TEST(SupportMesh, RandomCellsHaveAFaceForEachEmptyNeighbour) {
  std::mt19937_64 random(8);
  std::vector<Vec3l> cells;
  for (int n = 0; n < 4000; ++n) {
    const auto coordinate = [&] { return std::int64_t(random() % 24) - 12; };
    cells.push_back({coordinate(), coordinate(), coordinate()});
  }
  const Support support = make_support(cells);
  std::size_t faces = 0;
  for (int x = -12; x < 12; ++x) {
    for (int y = -12; y < 12; ++y) {
      for (int z = -12; z < 12; ++z) {
        const Vec3l cell{x, y, z};
        if (!is_occupied(support, cell)) continue;
        for (const Vec3l step : {Vec3l{1, 0, 0}, Vec3l{0, 1, 0}, Vec3l{0, 0, 1}}) {
          faces += !is_occupied(support, cell + step);
          faces += !is_occupied(support, cell - step);
        }
      }
    }
  }
  const TriangleMesh mesh = make_mesh(support);
  EXPECT_EQ(mesh.triangles.size(), 2 * faces);
  EXPECT_EQ(volume(mesh), double(support.cells));
}

TEST(SupportMesh, NoCellsAreAnEmptyMesh) { EXPECT_TRUE(make_mesh(Support{}).triangles.empty()); }

}  // namespace mesh_test
}  // namespace pvol
