#include "pvol/shell/fit_shell.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <functional>

#include "pvol/error.h"
#include "pvol/shell/certificate.h"
#include "pvol/shell/tightness.h"
#include "support/effort.h"

namespace pvol {
namespace fit_shell_test {

/// Cells of [-n, n)^3 at whose centre `inside` holds.
std::vector<Vec3l> cells_where(int n, const std::function<bool(Vec3d)>& inside) {
  std::vector<Vec3l> cells;
  for (Vec3l c(-n); c.z < n; ++c.z) {
    for (c.y = -n; c.y < n; ++c.y) {
      for (c.x = -n; c.x < n; ++c.x) {
        if (inside(Vec3d(c) + Vec3d(0.5))) cells.push_back(c);
      }
    }
  }
  return cells;
}

std::vector<Vec3l> ball(int r) {
  return cells_where(r, [&](Vec3d p) { return length(p) <= r; });
}
std::vector<Vec3l> dumb_bell() {
  return cells_where(12, [](Vec3d p) {
    const Vec3d end{std::abs(p.x) - 7, p.y, p.z};
    return length(end) <= 5 || std::hypot(p.y, p.z) <= 1;
  });
}
std::vector<Vec3l> torus() {
  return cells_where(11, [](Vec3d p) { return std::hypot(std::hypot(p.x, p.y) - 7.5, p.z) <= 3; });
}

long double exactly(const Quadric& q, const std::array<long double, 3>& p) {
  const auto [x, y, z] = p;
  return q.square.x * x * x + q.square.y * y * y + q.square.z * z * z + q.mixed.x * y * z +
         q.mixed.y * z * x + q.mixed.z * x * y + q.linear.x * x + q.linear.y * y + q.linear.z * z +
         q.constant;
}

/// The slack by its definition, in long double.
long double slack_exactly(const Shell& shell, const std::array<long double, 3>& p) {
  const bool hard = shell.kind == ShellKind::hard;
  long double united = exactly(shell.form.base, p);
  long double apart = std::numeric_limits<long double>::infinity();
  for (const Perturbation& r : shell.form.perturbations) {
    const long double q = exactly(r.form.base, p);
    if (!hard) {
      if (q > 0) united += r.strength * q * q;
    } else if (r.strength > 0) {
      united = std::max(united, q);
    } else {
      apart = std::min(apart, -q);
    }
  }
  return std::min(united, apart);
}

/// The least slack at 27 points of each cell, in the shell's frame.
long double least_slack(const Shell& shell, const std::vector<Vec3l>& cells) {
  const ShellFrame f = frame(shell);
  long double least = std::numeric_limits<long double>::infinity();
  for (const Vec3l& c : cells) {
    for (int i = 0; i < 27; ++i) {
      const long double steps[3] = {i % 3 * 0.5L, i / 3 % 3 * 0.5L, i / 9 * 0.5L};
      std::array<long double, 3> p;
      for (int axis = 0; axis < 3; ++axis) {
        p[std::size_t(axis)] =
            ((long double)(c[axis]) + steps[axis] - f.centre[axis]) / f.unit;  // NOLINT
      }
      least = std::min(least, slack_exactly(shell, p));
    }
  }
  return least;
}

Shell fit(const std::vector<Vec3l>& cells, ShellKind kind, std::optional<int> perturbations) {
  return fit_shell(make_support(cells), {kind, perturbations, 1});
}

/// A valid shell that holds the cells.
void expect_holds(const Shell& shell, const std::vector<Vec3l>& cells) {
  EXPECT_EQ(validate(shell).value_or("valid"), "valid");
  const Support support = make_support(cells);
  EXPECT_EQ(shell.lo, support.lo);
  EXPECT_EQ(shell.hi, support.hi);
  EXPECT_GE(shell.certificate.bound, evaluator_margin(shell));
  EXPECT_EQ(certify(shell, support), shell.certificate);
  EXPECT_GE(least_slack(shell, cells), shell.certificate.bound);
  const ShellTightness& t = shell.tightness;
  EXPECT_GE(t.volume_ratio, 1 - 1e-9);
  EXPECT_LE(t.volume_ratio, t.box_volume_ratio * (1 + 1e-9));
  EXPECT_TRUE(std::isfinite(t.hit_ratio) && t.hit_ratio <= t.box_hit_ratio);
}

TEST(FitShell, FindsTheEllipsoidAroundABall) {
  const std::vector<Vec3l> cells = ball(24);
  const Shell shell = fit(cells, ShellKind::hard, 0);
  expect_holds(shell, cells);
  EXPECT_TRUE(shell.form.perturbations.empty());
  // Cells of the ball reach out by up to half a diagonal: ((24 + 0.87) / 24)^3 = 1.112.
  EXPECT_LT(shell.tightness.volume_ratio, 1.112);
  EXPECT_LT(shell.tightness.hit_ratio, 1.05);
}

TEST(FitShell, DentsADumbBellAndATorus) {
  std::size_t turn = 0;
  for (const auto& cells : {dumb_bell(), torus()}) {
    ++turn;
    const double without = fit(cells, ShellKind::hard, 0).tightness.volume_ratio;
    for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
      if (!proof::has_turn(turn + (kind == ShellKind::soft))) continue;
      const Shell shell = fit(cells, kind, 3);
      expect_holds(shell, cells);
      EXPECT_EQ(shell.kind, kind);
      EXPECT_EQ(shell.form.perturbations.size(), 3u);
      EXPECT_LT(shell.tightness.volume_ratio - 1, 0.7 * (without - 1));
    }
  }
}

TEST(FitShell, GetsTighterWithMorePerturbations) {
  const std::vector<Vec3l> cells = torus();
  double last = std::numeric_limits<double>::infinity();
  for (const int k : {0, 1, 4}) {
    const double now = fit(cells, ShellKind::hard, k).tightness.volume_ratio;
    EXPECT_LT(now, last) << k;
    last = now;
  }
}

TEST(FitShell, DoesNotDependOnTheNumberOfThreads) {
  const std::vector<Vec3l> cells = dumb_bell();
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    Shell shells[2];
    for (const int threads : {1, 2}) {
      tbb::task_arena arena(threads);
      arena.execute([&] { shells[threads - 1] = fit(cells, kind, 2); });
    }
    EXPECT_EQ(shells[0], shells[1]);
  }
}

TEST(FitShell, HoldsDegenerateClouds) {
  const auto line = [](Vec3l step) {
    std::vector<Vec3l> cells;
    for (std::int64_t i = 0; i < 24; ++i) {
      for (int c = 0; c < 8; ++c) cells.push_back(step * i + Vec3l(c & 1, c >> 1 & 1, c >> 2));
    }
    return cells;
  };
  std::vector<Vec3l> sheet;
  for (std::int64_t y = 0; y < 24; ++y) {
    for (std::int64_t x = 0; x < 24; ++x) sheet.emplace_back(x, y, (2 * x + y) / 3);
  }
  const std::vector<Vec3l> clouds[] = {{{5, -3, 2}},
                                       line({1, 0, 0}),
                                       line({1, 1, 1}),
                                       sheet,
                                       cells_where(4, [](Vec3d) { return true; }),
                                       {{0, 0, 0}, {63, 63, 63}},
                                       {{0, 0, 0}, {1000000, 1, -1000000}},
                                       {{-100000000, 7, 7}, {-100000000, 8, 7}}};
  std::size_t turn = 0;
  for (const auto& cells : clouds) {
    ++turn;
    for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
      if (!proof::has_turn(turn + (kind == ShellKind::soft))) continue;
      expect_holds(fit(cells, kind, 1), cells);
    }
  }
}

TEST(FitShell, TakesAHugeCubeWhole) {
  // A full cube of 4096^3 cells, which no list of cells could hold.
  Support support;
  support.root_log2 = 12;
  support.hi = Vec3l(4096);
  support.cells = std::uint64_t(1) << 36;
  support.blocks.push_back({0, 9, 0});
  const Shell shell = fit_shell(support, {ShellKind::hard, 2, 1});
  EXPECT_EQ(validate(shell).value_or("valid"), "valid");
  EXPECT_DOUBLE_EQ(shell.tightness.volume_ratio, 1);
  EXPECT_DOUBLE_EQ(shell.tightness.box_volume_ratio, 1);
}

TEST(FitShell, StopsEarlyWhereNothingIsLeftToSave) {
  const Shell shell = fit(ball(16), ShellKind::hard, std::nullopt);
  EXPECT_LE(shell.form.perturbations.size(), 1u);
}

// Between three arms from a corner there is room for many lines that a mere ellipsoid lets in.
TEST(FitShell, SpendsPerturbationsWhereTheyPay) {
  const std::vector<Vec3l> cells = cells_where(
      28, [](Vec3d p) { return int(p.x < -20) + int(p.y < -20) + int(p.z < -20) >= 2; });
  const Shell shell = fit(cells, ShellKind::hard, std::nullopt);
  expect_holds(shell, cells);
  EXPECT_GE(shell.form.perturbations.size(), 1u);
  const auto cost = [](const Shell& s) {
    return expected_cost(s.tightness, s.kind, int(s.form.perturbations.size()));
  };
  EXPECT_LT(cost(shell), cost(fit(cells, ShellKind::hard, 0)));
  EXPECT_LT(cost(shell), cost(fit(cells, ShellKind::hard, 8)));
}

TEST(FitShell, ReportsProgressUpToTheTotal) {
  for (const std::optional<int> k : {std::optional<int>(1), std::optional<int>()}) {
    for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
      std::uint64_t last = 0, whole = 0;
      const Support support = make_support(ball(6));
      (void)fit_shell(support, {kind, k, 1}, [&](std::uint64_t done, std::uint64_t total) {
        EXPECT_GT(done, last);
        EXPECT_LE(done, total);
        last = done;
        whole = total;
      });
      EXPECT_GT(whole, 0u);
      EXPECT_EQ(last, whole);
    }
  }
}

TEST(FitShell, RefusesWhatItCannotFit) {
  const Support support = make_support({{0, 0, 0}});
  EXPECT_THROW((void)fit_shell({}), Error);
  EXPECT_THROW((void)fit_shell(support, {ShellKind::hard, -1, 1}), Error);
  EXPECT_THROW((void)fit_shell(support, {ShellKind::hard, kMaxPerturbations + 1, 1}), Error);
  EXPECT_THROW((void)fit_shell(support, {ShellKind::soft, kMaxSoftPerturbations + 1, 1}), Error);
  EXPECT_THROW((void)fit_shell(support, {ShellKind::hard, 1, 0}), Error);
  EXPECT_THROW((void)fit_shell(support, {ShellKind::hard, 1, 11}), Error);
}

}  // namespace fit_shell_test
}  // namespace pvol
