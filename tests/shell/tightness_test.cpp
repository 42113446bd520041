#include "pvol/shell/tightness.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace pvol {
namespace tightness_test {

using std::numbers::pi;

Support box_of_cells(Vec3l lo, Vec3l hi) {
  std::vector<Vec3l> cells;
  for (Vec3l c = lo; c.z < hi.z; ++c.z) {
    for (c.y = lo.y; c.y < hi.y; ++c.y) {
      for (c.x = lo.x; c.x < hi.x; ++c.x) cells.push_back(c);
    }
  }
  return make_support(cells);
}

/// Cells whose centre lies in the ball around the middle of [-r, r]^3.
Support ball_of_cells(int r) {
  std::vector<Vec3l> cells;
  for (Vec3l c(-r); c.z < r; ++c.z) {
    for (c.y = -r; c.y < r; ++c.y) {
      for (c.x = -r; c.x < r; ++c.x) {
        if (length(Vec3d(c) + Vec3d(0.5)) <= r) cells.push_back(c);
      }
    }
  }
  return make_support(cells);
}

Shell shell_around(const Support& support, ShellKind kind, FreeForm form) {
  Shell shell;
  shell.kind = kind;
  shell.lo = support.lo;
  shell.hi = support.hi;
  shell.form = std::move(form);
  return shell;
}

TEST(Tightness, OfABoxAroundABoxIsOne) {
  const Support support = box_of_cells({-3, 5, 2}, {4, 25, 60});
  FreeForm everywhere;
  everywhere.base.constant = 1;
  const ShellTightness t =
      measure_tightness(shell_around(support, ShellKind::hard, everywhere), support, 1 << 12);
  EXPECT_DOUBLE_EQ(t.volume_ratio, 1);
  EXPECT_DOUBLE_EQ(t.box_volume_ratio, 1);
  EXPECT_NEAR(t.hit_ratio, 1, 1e-3);  // lines that graze an edge
  EXPECT_NEAR(t.box_hit_ratio, 1, 1e-3);
}

// Volumes: box over ball 6/pi. Lines: a convex body is met in proportion to its surface (Cauchy),
// box over ball 24 r^2 / (4 pi r^2), again 6/pi. The cells themselves reach out of the ball by up
// to half a diagonal and are met a little more often.
TEST(Tightness, OfABoxAroundABallIsSixOverPi) {
  const Support support = ball_of_cells(40);
  const double cells = double(support.cells);
  const double unit = frame(support.lo, support.hi).unit;
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const FreeForm ball{ellipsoid({}, Vec3d(40 / unit)), {}};
    const ShellTightness t = measure_tightness(shell_around(support, kind, ball), support, 1 << 16);
    EXPECT_DOUBLE_EQ(t.box_volume_ratio, 80.0 * 80 * 80 / cells);
    EXPECT_NEAR(t.volume_ratio, 4 * pi / 3 * 64000 / cells, 5e-4);
    EXPECT_NEAR(t.box_hit_ratio / t.hit_ratio, 6 / pi, 0.03);
    EXPECT_LT(t.hit_ratio, 1);
    EXPECT_GT(t.hit_ratio, std::pow(40 / (40 + std::sqrt(0.75)), 2));
  }
}

/// By Cauchy's formula the mean shadow of a convex body is a quarter of its surface. In the world
/// the ball of cells is an ellipsoid of radii 1, 1 and 2.
TEST(Tightness, LinesAreThoseOfTheWorld) {
  const Support support = ball_of_cells(40);
  const double unit = frame(support.lo, support.hi).unit;
  const Shell ball = shell_around(support, ShellKind::hard, {ellipsoid({}, Vec3d(40 / unit)), {}});
  const double e = std::sqrt(0.75), ellipsoid_surface = 2 * pi * (1 + 2 / e * std::asin(e));
  const double box_surface = 2 * (2 * 2 + 2 * 4 + 4 * 2);
  Affine turned;  // by 37 degrees about x
  turned.m = {Vec3d{1, 0, 0}, Vec3d{0, 0.8, -0.6}, Vec3d{0, 0.6, 0.8}};
  for (const Affine& place : {Affine{}, turned}) {
    const ShellTightness t =
        measure_tightness(ball, support, 1 << 18, place * scaling(Vec3d(20, 20, 40)));
    EXPECT_NEAR(t.box_hit_ratio / t.hit_ratio, box_surface / ellipsoid_surface, 0.012);
  }
}

// Half of a unit-strength dent's body {Q > 0} lies in the ball, where it is cut away; a soft dent
// cuts less.
TEST(Tightness, KnowsWhatDentsAndBulgesDo) {
  const Support support = box_of_cells({-32, -32, -32}, {32, 32, 32});
  FreeForm form;
  form.base.constant = 1;
  form.perturbations.push_back({FreeForm{ellipsoid({1, 0, 0}, Vec3d(0.5)), {}}, -1});
  const double box = 8, hemisphere = 2 * pi / 3 * 0.125;
  const Shell dented = shell_around(support, ShellKind::hard, form);
  EXPECT_NEAR(measure_tightness(dented, support, 16).volume_ratio, (box - hemisphere) / box, 1e-4);

  FreeForm bulged;
  bulged.base = ellipsoid({-0.5, 0, 0}, Vec3d(0.25));
  bulged.perturbations.push_back({FreeForm{ellipsoid({0.5, 0, 0}, Vec3d(0.375)), {}}, 1});
  const double balls = 4 * pi / 3 * (std::pow(0.25, 3) + std::pow(0.375, 3));
  const Shell two = shell_around(support, ShellKind::hard, bulged);
  EXPECT_NEAR(measure_tightness(two, support, 16).volume_ratio, balls / box, 1e-4);

  // 1 - 16 max(0, 1 - 4 r^2)^2 >= 0 from 4 r^2 >= 3/4 on.
  form.perturbations[0].strength = -16;
  const Shell soft = shell_around(support, ShellKind::soft, form);
  EXPECT_NEAR(measure_tightness(soft, support, 16).volume_ratio,
              (box - 2 * pi / 3 * std::pow(3.0 / 16, 1.5)) / box, 1e-4);
}

/// Hit ratios of one ball by blocks of lines: the spread is that of counts of which one is part of
/// the other, larger for the box than for the shell.
TEST(Tightness, StandardErrorsAreThoseOfHits) {
  constexpr std::uint64_t kLines = 1 << 10;
  constexpr int kBlocks = 40;
  const Support support = ball_of_cells(6);
  const double unit = frame(support.lo, support.hi).unit;
  const Shell shell = shell_around(support, ShellKind::hard, {ellipsoid({}, Vec3d(7 / unit)), {}});
  struct Hits {
    double support = 0, shell = 0;
  };
  Hits before;
  std::array<std::vector<double>, 2> ratios;  // of the shell and of the box
  std::array<double, 2> error{};
  for (int k = 1; k <= kBlocks; ++k) {
    const std::uint64_t lines = std::uint64_t(k) * kLines;
    const ShellTightness t = measure_tightness(shell, support, lines);
    Hits all;
    all.support = double(lines) / t.box_hit_ratio, all.shell = t.hit_ratio * all.support;
    const double met = all.support - before.support;
    const std::array of = {(all.shell - before.shell) / met, double(kLines) / met};
    for (std::size_t i = 0; i < of.size(); ++i) {
      ratios[i].push_back(of[i]);
      error[i] += *standard_error_of_hits(of[i], of[1], kLines) / kBlocks;
    }
    before = all;
  }
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const double mean = std::accumulate(ratios[i].begin(), ratios[i].end(), 0.0) / kBlocks;
    double squares = 0;
    for (const double r : ratios[i]) squares += (r - mean) * (r - mean);
    EXPECT_NEAR(std::sqrt(squares / (kBlocks - 1)) / error[i], 1, 0.35) << i;
  }
  EXPECT_FALSE(standard_error_of_hits(2, 40000));
}

TEST(Tightness, CopesWithHugeAndFarApartSupports) {
  constexpr std::int64_t kFar = 1 << 20;
  const Support far = make_support({{0, 0, 0}, {kFar, kFar, kFar}});
  FreeForm everywhere;
  everywhere.base.constant = 1;
  const ShellTightness t =
      measure_tightness(shell_around(far, ShellKind::hard, everywhere), far, 1 << 10);
  EXPECT_NEAR(t.volume_ratio, t.box_volume_ratio, 1e-9 * t.box_volume_ratio);
  EXPECT_TRUE(std::isfinite(t.hit_ratio) && t.hit_ratio > 0);
}

TEST(Tightness, IsTheSameTwice) {
  const Support support = ball_of_cells(10);
  const Shell shell = shell_around(support, ShellKind::hard, {ellipsoid({}, Vec3d(0.7)), {}});
  EXPECT_EQ(measure_tightness(shell, support, 5000), measure_tightness(shell, support, 5000));
}

/// Where the ray is in occupied cells, by intersecting each of them.
std::optional<Span> brute_force(const std::vector<Vec3l>& cells, const Ray& ray) {
  std::optional<Span> hull;
  for (const Vec3l& c : cells) {
    const auto s = intersect({Vec3d(c), Vec3d(c) + Vec3d(1)}, ray, 0, 1e300);
    if (!s) continue;
    if (!hull) hull = s;
    hull = Span{std::min(hull->t0, s->t0), std::max(hull->t1, s->t1)};
  }
  return hull;
}

TEST(FirstAndLast, AgreesWithAllCellsTestedOneByOne) {
  std::mt19937_64 random(4);
  const auto uniform = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };
  int met = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<Vec3l> cells;
    for (int i = 0; i < 60; ++i) {
      cells.emplace_back(std::int64_t(uniform(-20, 20)), std::int64_t(uniform(-20, 20)),
                         std::int64_t(uniform(-20, 20)));
    }
    for (Vec3l c; c.x < 512; ++c.x) {
      cells.emplace_back(8 + c.x % 8, c.x / 8 % 8, c.x / 64);  // a block that is full
    }
    const Support support = make_support(cells);
    for (int i = 0; i < 200; ++i) {
      Ray ray{{uniform(-40, 40), uniform(-40, 40), uniform(-40, 40)},
              {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}};
      if (i % 4 == 0) ray.d[i / 4 % 3] = i % 8 == 0 ? 0.0 : -0.0;
      if (i % 5 == 0) ray.d = Vec3d(cells[std::size_t(i)]) + Vec3d(0.5) - ray.o;
      const auto expected = brute_force(cells, ray), found = first_and_last(support, ray);
      ASSERT_EQ(bool(found), bool(expected));
      if (!found) continue;
      ++met;
      EXPECT_NEAR(found->t0, expected->t0, 1e-9);
      EXPECT_NEAR(found->t1, expected->t1, 1e-9);
    }
  }
  EXPECT_GT(met, 1000);
}

TEST(FirstAndLast, StartsAtTheOriginOfARayFromInside) {
  const Support support = box_of_cells({0, 0, 0}, {8, 8, 8});
  const auto s = first_and_last(support, {{4, 4, 4}, {0, 0, -2}});
  ASSERT_TRUE(s);
  EXPECT_EQ(s->t0, 0);
  EXPECT_EQ(s->t1, 2);
  EXPECT_FALSE(first_and_last(support, {{4, 4, 9}, {0, 0, 1}}));
  EXPECT_FALSE(first_and_last({}, {{4, 4, 9}, {0, 0, -1}}));
}

}  // namespace tightness_test
}  // namespace pvol
