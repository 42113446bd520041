#include "pvol/shell/certificate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "pvol/shell/ray_shell.h"
#include "support/effort.h"
#include "support/shell_samples.h"

namespace pvol {
namespace certificate_test {

using proof::Draw;
using proof::Vec3x;

/// Balls, single cells, sheets and lines, anywhere on the lattice.
std::vector<Vec3l> any_cells(Draw& draw) {
  std::vector<Vec3l> cells;
  const Vec3l at(draw.point(1e4));
  const int kind = draw.index(5);
  if (kind < 2) cells = proof::ball_cells(draw, 16 + draw.index(20), 4);
  if (kind == 2) cells = {{0, 0, 0}};
  if (kind == 3) {  // a full cube that is not aligned
    const int edge = 1 + draw.index(20);
    for (int i = 0; i < edge * edge * edge; ++i) {
      cells.emplace_back(i % edge, i / edge % edge, i / edge / edge);
    }
  }
  if (kind == 4) {
    for (int i = 0; i < 30; ++i) cells.emplace_back(draw.point(20));
  }
  for (Vec3l& cell : cells) cell += at;
  return cells;
}

Shell any_shell(Draw& draw, const Support& support) {
  const ShellKind kind = draw.index(2) ? ShellKind::hard : ShellKind::soft;
  Shell shell = proof::fitted_shell(draw, support, kind, draw.index(18));
  // Not fitted, and bulges of hard shells.
  for (Perturbation& r : shell.form.perturbations) {
    if (draw.index(4) == 0) r.form.base = proof::random_side(draw, draw.log_uniform(1, 30));
    if (draw.index(4) == 0) r.strength = -r.strength;
  }
  shell.form = round_to_float(shell.form);
  return shell;
}

/// The least of `f` over `steps`^3 points of a cube in the shell's frame.
struct Sampled {
  double least = std::numeric_limits<double>::infinity();
  Vec3d where;
};
template <class F>
Sampled sample(const F& f, Vec3d lo, Vec3d hi, int steps) {
  Sampled s;
  for (int i = 0; i < steps * steps * steps; ++i) {
    const Vec3d at{double(i % steps), double(i / steps % steps), double(i / steps / steps)};
    const Vec3d p = lo + (hi - lo) * (at * (1.0 / (steps - 1)));
    const double v = f(p);
    if (v < s.least) s = {v, p};
  }
  return s;
}

/// 27 points of every cell or more; around the lowest ones ever closer.
template <class F>
Sampled brute_force(const F& f, const std::vector<Vec3l>& cells, const ShellFrame& frame) {
  struct Candidate {
    Sampled sampled;
    Vec3d lo, hi;
  };
  const int steps = cells.size() < 100 ? 17 : 3;  // few cells are large against the form
  std::vector<Candidate> candidates;
  for (const Vec3l& cell : cells) {
    const Vec3d lo = frame.to_shell(Vec3d(cell)), hi = frame.to_shell(Vec3d(cell) + Vec3d(1));
    candidates.push_back({sample(f, lo, hi, steps), lo, hi});
  }
  const std::size_t few = std::min<std::size_t>(30, candidates.size());
  std::partial_sort(
      candidates.begin(), candidates.begin() + std::ptrdiff_t(few), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.sampled.least < b.sampled.least; });
  Sampled best = candidates.front().sampled;
  for (std::size_t i = 0; i < few; ++i) {
    const Candidate& c = candidates[i];
    Sampled here = c.sampled;
    Vec3d half = (c.hi - c.lo) * 0.5;
    for (int round = 0; round < 14; ++round, half *= 0.5) {
      const Sampled s = sample(f, max(c.lo, here.where - half), min(c.hi, here.where + half), 5);
      if (s.least < here.least) here = s;
    }
    if (here.least < best.least) best = here;
  }
  return best;
}

/// The least slack over the cells. A hard shell's is searched dent by dent, so that none hides
/// another.
Sampled least_slack(const Shell& shell, const std::vector<Vec3l>& cells) {
  const ShellFrame f = frame(shell);
  Sampled best = brute_force([&](Vec3d p) { return slack(shell, p); }, cells, f);
  if (shell.kind == ShellKind::soft) return best;
  for (const Perturbation& r : shell.form.perturbations) {
    if (r.strength > 0) continue;
    const Sampled s = brute_force([&](Vec3d p) { return -value(r.form.base, p); }, cells, f);
    if (s.least < best.least) best = s;
  }
  return best;
}

TEST(Certificate, BoundIsBelowBruteForceAndCloseToIt) {
  constexpr CertifyOptions kOptions{1e-6, -12};
  for (std::uint64_t n = 0; n < proof::samples(300u, 3u); ++n) {
    Draw draw(1, n);
    const std::vector<Vec3l> cells = any_cells(draw);
    const Support support = make_support(cells);
    const Shell shell = any_shell(draw, support);
    const Certificate c = certify(shell, support, kOptions);
    const Sampled least = least_slack(shell, cells);
    ASSERT_LE(c.bound, least.least) << n;
    ASSERT_LE(c.bound, double(proof::exact_slack(shell, Vec3x(least.where)))) << n;
    // The search itself is only so good.
    ASSERT_GE(c.bound, least.least - kOptions.tolerance * (2 + std::abs(least.least))) << n;
    ASSERT_GE(c.boxes, 1u);
    ASSERT_GE(c.depth, -12);
  }
}

TEST(Certificate, BoundFromAboveHoldsForFreeFormsNestedOnesToo) {
  constexpr CertifyOptions kOptions{1e-6, -12};
  for (std::uint64_t n = 0; n < 150; ++n) {
    Draw draw(2, n);
    const std::vector<Vec3l> cells = any_cells(draw);
    const Support support = make_support(cells);
    const ShellFrame f = frame(support.lo, support.hi);
    FreeForm form{proof::random_side(draw, 3), {}};
    for (int i = draw.index(4); i > 0; --i) {
      FreeForm inner{proof::random_side(draw, 3), {}};
      if (draw.index(2)) {
        inner.perturbations.push_back({{proof::random_side(draw, 3), {}}, draw.uniform(-1, 1)});
      }
      form.perturbations.push_back({inner, draw.uniform(-1, 1)});
    }
    const Certificate c = certify_above(form, support, f, kOptions);
    const double greatest = -brute_force([&](Vec3d p) { return -value(form, p); }, cells, f).least;
    ASSERT_GE(c.bound, greatest) << n;
    ASSERT_LE(c.bound, greatest + 2 * kOptions.tolerance) << n;
  }
}

TEST(Certificate, HoldsForAFittedShellAndFailsForACorruptedOne) {
  Draw draw(3);
  const std::vector<Vec3l> cells = proof::ball_cells(draw, 64, 20);
  const Support support = make_support(cells);
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const Shell shell = proof::fitted_shell(draw, support, kind, 16);
    const double bound = certify(shell, support).bound;
    EXPECT_GT(bound, evaluator_margin(shell));
    // A change that pushes the surface past the tightest cells.
    Shell bad = shell;
    if (kind == ShellKind::hard) {
      bad.form.perturbations[3].form.base.constant += 3 * bound + 1e-3;
    } else {
      bad.form.base.constant -= 1.5 * bound;
    }
    EXPECT_LT(certify(bad, support).bound, 0);
  }
}

TEST(Certificate, StopsWhereEnoughIsKnown) {
  Draw draw(4);
  const Support support = make_support(proof::ball_cells(draw, 64, 20));
  const Shell shell = proof::fitted_shell(draw, support, ShellKind::hard, 16, 1e-2);
  const Certificate whole = certify(shell, support);
  CertifyOptions options;
  options.enough = 0.5 * whole.bound;
  const Certificate enough = certify(shell, support, options);
  EXPECT_GE(enough.bound, options.enough);
  EXPECT_LE(enough.bound, whole.bound + options.tolerance);
  EXPECT_LT(enough.boxes, whole.boxes);
  // From above the same of the negative: it stops at or below -enough.
  const FreeForm dent{shell.form.perturbations[0].form};
  const Certificate above = certify_above(dent, support, frame(shell));
  options.enough = -0.5 * above.bound;
  EXPECT_LE(certify_above(dent, support, frame(shell), options).bound, 0.5 * above.bound);
}

TEST(Certificate, OfOneCellIsItsLowestCorner) {
  const Support support = make_support(std::vector<Vec3l>{{5, -3, 7}});
  Shell shell;
  shell.lo = support.lo;
  shell.hi = support.hi;
  shell.form.base = ellipsoid({}, Vec3d(1));
  const Certificate c = certify(shell, support);
  EXPECT_NEAR(c.bound, 0.25, 1e-12);  // 1 - 3/4 at the corners of a cube of half extent 1/2
  EXPECT_LE(c.bound, 0.25);
  EXPECT_LE(c.boxes, 64u);
}

TEST(Certificate, OfNoCellsIsInfinite) {
  Shell shell;
  shell.hi = Vec3l(8);
  EXPECT_EQ(certify(shell, Support{}).bound, std::numeric_limits<double>::infinity());
  EXPECT_EQ(certify(shell, Support{}).boxes, 0u);
}

// The cost that fits pay again and again.
TEST(Certificate, TakesFewBoxes) {
  Draw draw(5);
  const Support support = make_support(proof::ball_cells(draw, 128, 40));
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const Certificate c = certify(proof::fitted_shell(draw, support, kind, 16), support);
    EXPECT_LT(c.boxes, 20000u);
  }
}

TEST(EvaluatorMargin, CoversTheExcessOfRaysNearby) {
  Draw draw(6);
  const Support support = make_support(proof::ball_cells(draw, 32, 4));
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const Shell shell = proof::fitted_shell(draw, support, kind, 8);
    EXPECT_GE(evaluator_margin(shell), RayShell(shell).excess(1));
    EXPECT_LT(evaluator_margin(shell), 1e-5);
  }
}

}  // namespace certificate_test
}  // namespace pvol
