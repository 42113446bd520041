#include "shellcheck.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "pvol/error.h"
#include "support/messages.h"

namespace pvol {
namespace shellcheck_test {

Quadric ball(Vec3d centre, double radius) {
  return {Vec3d(-1), {}, 2.0 * centre, radius * radius - dot(centre, centre)};
}
constexpr Quadric kEverywhere{{}, {}, {}, 1};

/// Cells whose centre lies within `radius` of the middle of `size`^3 cells, which touch each side.
Support ball_of_cells(int size, Vec3l origin = {}) {
  std::vector<Vec3l> cells;
  const double middle = 0.5 * size;
  for (int x = 0; x < size; ++x) {
    for (int y = 0; y < size; ++y) {
      for (int z = 0; z < size; ++z) {
        const Vec3d centre{x + 0.5, y + 0.5, z + 0.5};
        if (length(centre - Vec3d(middle)) < middle) cells.push_back(origin + Vec3l(x, y, z));
      }
    }
  }
  return make_support(cells);
}

Shell shell_around(const Support& support, ShellKind kind, const FreeForm& form) {
  Shell s;
  s.kind = kind;
  s.lo = support.lo, s.hi = support.hi;
  s.form = round_to_float(form);
  return s;
}

/// A point of index space in a shell's frame.
Vec3d in_frame(const Support& support, Vec3d index) {
  return frame(support.lo, support.hi).to_shell(index);
}

bool touches_occupied(const Support& support, Vec3d p) {
  for (int n = 0; n < 27; ++n) {
    const Vec3l cell(Vec3d{std::floor(p.x) + n % 3 - 1, std::floor(p.y) + n / 3 % 3 - 1,
                           std::floor(p.z) + n / 9 - 1});
    if (is_occupied(support, cell) && Box{Vec3d(cell), Vec3d(cell + Vec3l(1))}.contains(p)) {
      return true;
    }
  }
  return false;
}

ShellCheckOptions coarse() {
  ShellCheckOptions options;
  options.mesh_resolution = 32;
  return options;
}

void expect_caught(const Shell& shell, const Support& support, const std::string& what) {
  const ShellCheck check = check_shell(shell, support, coarse());
  EXPECT_FALSE(check.contained) << what;
  ASSERT_TRUE(check.witness) << what;
  EXPECT_EQ(check.witness->what, what);
  EXPECT_TRUE(touches_occupied(support, check.witness->index)) << what;
  const Vec3d p = frame(shell).to_shell(check.witness->index);
  EXPECT_LT(slack(shell, p), 0) << what;
  EXPECT_NEAR(slack(shell, p), check.witness->value, 1e-9) << what;
  EXPECT_TRUE(says(describe(check), "shell.not_contained_cuts", {what}));
}

/// A ball of 40 cells in a sphere with a dent above and one at a side that stop short of the cells.
Shell dented_shell(const Support& support) {
  const double radius = 20.9 / 32;  // the frame's unit is 32 cells
  return shell_around(
      support, ShellKind::hard,
      {ball({}, radius), {{{ball({0, 0, 1.1}, 0.4), {}}, -1}, {{ball({-1, -1, 0}, 0.7), {}}, -1}}});
}

/// The same with a bulge, as a sum.
Shell soft_shell(const Support& support) {
  return shell_around(support, ShellKind::soft,
                      {ball({}, 21.5 / 32),
                       {{{ball({0, 0, 1.1}, 0.4), {}}, -3}, {{ball({0.6, 0, 0}, 0.2), {}}, 2}}});
}

TEST(ShellCheck, ShellsThatHoldTheirCellsPass) {
  const Support support = ball_of_cells(40, {-1000, 7, 123456});
  for (const Shell& shell : {dented_shell(support), soft_shell(support),
                             shell_around(support, ShellKind::soft, {kEverywhere, {}}),
                             shell_around(support, ShellKind::hard, {kEverywhere, {}})}) {
    const ShellCheck check = check_shell(shell, support, coarse());
    EXPECT_TRUE(check.contained);
    EXPECT_FALSE(check.witness);
    EXPECT_TRUE(check.mesh_contained);
    EXPECT_GE(check.rational, 2000u);
    EXPECT_GT(check.points, 10000u);
    EXPECT_EQ(describe(check).find("NOT"), std::string::npos);
  }
}

TEST(ShellCheck, CorruptedCoefficientsAreCaughtWithAWitness) {
  const Support support = ball_of_cells(40, {-1000, 7, 123456});
  const auto corrupted = [&](const std::function<void(FreeForm&)>& change) {
    Shell shell = dented_shell(support);
    change(shell.form);
    shell.form = round_to_float(shell.form);
    return shell;
  };
  const auto dent = [](FreeForm& f, std::size_t i) -> Quadric& {
    return f.perturbations[i].form.base;
  };
  expect_caught(corrupted([](FreeForm& f) { f.base.constant -= 0.05; }), support, "the form");
  expect_caught(corrupted([](FreeForm& f) { f.base.square.y *= 2; }), support, "the form");
  expect_caught(corrupted([](FreeForm& f) { f.base.linear.z = 0.1; }), support, "the form");
  expect_caught(corrupted([&](FreeForm& f) { dent(f, 0).constant += 0.2; }), support, "dent 0");
  expect_caught(corrupted([&](FreeForm& f) { dent(f, 0).constant *= -1; }), support, "dent 0");
  expect_caught(corrupted([&](FreeForm& f) { dent(f, 1).mixed.z = 3; }), support, "dent 1");
  expect_caught(corrupted([&](FreeForm& f) { dent(f, 1).square = {}; }), support, "dent 1");
}

TEST(ShellCheck, CorruptedSoftShellsAreCaught) {
  const Support support = ball_of_cells(40, {-1000, 7, 123456});
  const auto corrupted = [&](const std::function<void(FreeForm&)>& change) {
    Shell shell = soft_shell(support);
    change(shell.form);
    return shell;
  };
  expect_caught(corrupted([](FreeForm& f) { f.perturbations[0].form.base.constant += 0.3; }),
                support, "the form");
  expect_caught(corrupted([](FreeForm& f) { f.perturbations[1].strength = -200; }), support,
                "the form");
  expect_caught(corrupted([](FreeForm& f) { f.base.constant *= 0.9; }), support, "the form");
}

TEST(ShellCheck, DentsBetweenLatticePointsAreCaught) {
  const Support support = ball_of_cells(40);
  const auto with_dent = [&](Vec3d centre, double radius) {
    const Quadric dent = ball(in_frame(support, centre), radius / 32);
    return shell_around(support, ShellKind::hard, {kEverywhere, {{{dent, {}}, -1}}});
  };
  // Deep inside, where no point is taken: by its critical point.
  expect_caught(with_dent({20.37, 19.41, 21.6}, 0.1), support, "dent 0");
  // From outside into the middle of a face: its critical point lies in an empty cell.
  ASSERT_TRUE(is_occupied(support, {0, 20, 20}));
  expect_caught(with_dent({-0.05, 20.37, 20.63}, 0.1), support, "dent 0");
  // The same dents where they stop short of the cells.
  EXPECT_TRUE(check_shell(with_dent({-0.11, 20.37, 20.63}, 0.1), support, coarse()).contained);
}

TEST(ShellCheck, SoftDentInsideIsCaughtAtItsCriticalPoint) {
  const Support support = ball_of_cells(40);
  const Quadric dent = 100.0 * ball(in_frame(support, {20.37, 19.41, 21.6}), 0.1 / 32);
  const FreeForm form{{{}, {}, {}, 1e-7}, {{{dent, {}}, -1}}};
  expect_caught(shell_around(support, ShellKind::soft, form), support, "the form");
}

TEST(ShellCheck, SignsAreExactWhereDoublesCannotTell) {
  // F = 2^40 x^2 - 2^38 + e y on cells that begin at x = 1/2 of the frame: 2^38 hides the last
  // term.
  std::vector<Vec3l> cells;
  for (int y = 0; y < 4; ++y) {
    cells.push_back({6, y, 0});
    cells.push_back({7, y, 0});
  }
  const Support support = make_support(cells);
  const auto shell = [&](double e) {
    Shell s = shell_around(support, ShellKind::soft, {});
    s.lo = {0, 0, 0}, s.hi = {8, 4, 1};  // centre (4, 2, 1/2), unit 4: y spans [-1/2, 1/2]
    s.form.base.square.x = 0x1p40;
    s.form.base.constant = -0x1p38;
    s.form.base.linear = {0, e, 0};
    return s;
  };
  const ShellCheck exact = check_shell(shell(0), support, coarse());
  EXPECT_TRUE(exact.contained);  // the cells touch the surface
  const Shell wrong = shell(0x1p-30);
  EXPECT_GE(slack(wrong, frame(wrong).to_shell({6, 0, 0})), 0);
  const ShellCheck check = check_shell(wrong, support, coarse());
  EXPECT_FALSE(check.contained);
  ASSERT_TRUE(check.witness);
  EXPECT_EQ(check.witness->value, -0x1p-31);
  EXPECT_EQ(check.witness->index.x, 6);
  EXPECT_EQ(check.witness->index.y, 0);
}

TEST(ShellCheck, CellsBeyondTheBoxAreCaught) {
  const Support support = ball_of_cells(20);
  Shell shell = shell_around(support, ShellKind::hard, {kEverywhere, {}});
  --shell.hi.y;
  const ShellCheck check = check_shell(shell, support, coarse());
  EXPECT_FALSE(check.contained);
  ASSERT_TRUE(check.witness);
  EXPECT_EQ(check.witness->what, "the box");
  EXPECT_TRUE(touches_occupied(support, check.witness->index));
  EXPECT_EQ(check.witness->index.y, 20);
}

TEST(ShellCheck, DistancesHoldTheTrueOnes) {
  const Support support = ball_of_cells(40);
  const Shell box = shell_around(support, ShellKind::hard, {kEverywhere, {}});
  // The centre of the ball lies 20 cells from each side, and the box's corners are farthest.
  double farthest = 1e9, deepest = 0;
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) {
      for (int z = 0; z < 20; ++z) {
        if (!is_occupied(support, {x, y, z})) continue;
        farthest = std::min(farthest, length(Vec3d(x, y, z)));
        const bool open = !is_occupied(support, {x - 1, y, z}) ||
                          !is_occupied(support, {x, y - 1, z}) ||
                          !is_occupied(support, {x, y, z - 1});
        if (open) deepest = std::max(deepest, double(std::min({x, y, z})));
      }
    }
  }
  for (const std::uint64_t points : {200'000ull, 2'000ull}) {  // as it is, and thinned
    ShellCheckOptions options;
    options.mesh_resolution = 80;
    options.mesh_points = points;
    const ShellCheck c = check_shell(box, support, options);
    EXPECT_DOUBLE_EQ(c.mesh_step, 0.5);
    EXPECT_GE(c.shell_to_support, farthest);
    EXPECT_LE(c.shell_to_support - c.shell_to_support_excess, farthest);
    EXPECT_GE(c.support_to_shell, deepest);
    EXPECT_LE(c.support_to_shell - c.support_to_shell_excess, deepest + 1);
    EXPECT_LE(c.shell_to_support_excess, points == 2000 ? 9 : 2);
    EXPECT_LE(c.support_to_shell_excess, points == 2000 ? 10 : 3);
  }
}

TEST(ShellCheck, BaselinesHaveTheirClosedForms) {
  std::vector<Vec3l> cells;
  for (int i = 0; i < 1000; ++i) cells.push_back({1'000'000 + i % 10, i / 10 % 10, i / 100});
  const Support cube = make_support(cells);
  const ShellCheck c =
      check_shell(shell_around(cube, ShellKind::hard, {kEverywhere, {}}), cube, coarse());
  EXPECT_NEAR(c.hull_volume_ratio, 1, 1e-12);
  EXPECT_GE(c.ellipsoid_volume_ratio, std::numbers::pi * std::sqrt(3) / 2 - 1e-9);
  EXPECT_LE(c.ellipsoid_volume_ratio, std::numbers::pi * std::sqrt(3) / 2 * 1.011);
  EXPECT_NEAR(c.shell_volume_ratio, 1, 0.01);

  const Support ball = ball_of_cells(40);
  const ShellCheck b =
      check_shell(shell_around(ball, ShellKind::hard, {kEverywhere, {}}), ball, coarse());
  EXPECT_GE(b.hull_volume_ratio, 1);
  EXPECT_LE(b.hull_volume_ratio, 1.1);
  EXPECT_GE(b.ellipsoid_volume_ratio, b.hull_volume_ratio);
  EXPECT_NEAR(b.shell_volume_ratio, 6 / std::numbers::pi, 0.05);
}

TEST(ShellCheck, ThinShellsAreMeshedFinelyEnough) {
  // Two far cells in a tube: r^2 - |p|^2 + (p . d)^2 along the line through them.
  const Support pair = make_support({{0, 0, 0}, {100, 37, 21}});
  const double r = 1.2 / 64;
  const Vec3d d = normalize(Vec3d(100, 37, 21));
  const Quadric tube{d * d - Vec3d(1), 2.0 * Vec3d(d.y * d.z, d.z * d.x, d.x * d.y), {}, r * r};
  ShellCheckOptions options;
  options.mesh_resolution = 16;  // one step is 6 cells
  Shell shell = shell_around(pair, ShellKind::soft, {});
  shell.lo -= Vec3l(20, 7, 5), shell.hi += Vec3l(3, 17, 11);  // so that no corner helps
  const Vec3d middle = frame(shell).to_shell({50.5, 19, 11});
  shell.form = round_to_float({transform(translation(middle), tube), {}});
  const ShellCheck check = check_shell(shell, pair, options);
  EXPECT_TRUE(check.contained);
  EXPECT_TRUE(check.mesh_contained);
  EXPECT_LT(check.mesh_step, 4);
  EXPECT_GT(check.mesh_step, 0.2);
}

TEST(ShellCheck, IsTheSameEveryTime) {
  const Support support = ball_of_cells(24);
  const Shell shell = dented_shell(ball_of_cells(40));
  Shell small = shell;
  small.lo = support.lo, small.hi = support.hi;
  const ShellCheck a = check_shell(small, support, coarse()),
                   b = check_shell(small, support, coarse());
  EXPECT_EQ(describe(a), describe(b));
  EXPECT_EQ(a.rational, b.rational);
}

TEST(ShellCheck, RefusesAnEmptyCloudAndOptionsOutOfRange) {
  const Support support = ball_of_cells(4);
  const Shell shell = shell_around(support, ShellKind::hard, {kEverywhere, {}});
  EXPECT_THROW((void)check_shell(shell, Support{}), Error);
  ShellCheckOptions options;
  options.mesh_resolution = 4;
  EXPECT_THROW((void)check_shell(shell, support, options), Error);
  options = {};
  options.points = 0;
  EXPECT_THROW((void)check_shell(shell, support, options), Error);
}

}  // namespace shellcheck_test
}  // namespace pvol
