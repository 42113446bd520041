// Shells of real clouds: as tight as they should be, and no cell and no ray is lost.
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "pvol/formats/cloud.h"
#include "pvol/math/rng.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/shell/tightness.h"
#include "support/effort.h"

namespace pvol {
namespace shell_clouds_test {

struct Case {
  std::string file, grid;
  ShellKind kind = ShellKind::hard;
  double volume_ratio = 0;  ///< at most, with 16 perturbations
  double ratio_of_few = 0;  ///< with 6, as each commit fits one shell
};

class ShellOfCloud : public testing::TestWithParam<Case> {};

long double value_in_long_double(const Quadric& q, Vec3d p) {
  using L = long double;
  const L x = L(p.x), y = L(p.y), z = L(p.z);
  return L(q.square.x) * x * x + L(q.square.y) * y * y + L(q.square.z) * z * z +
         L(q.mixed.x) * y * z + L(q.mixed.y) * z * x + L(q.mixed.z) * x * y + L(q.linear.x) * x +
         L(q.linear.y) * y + L(q.linear.z) * z + L(q.constant);
}

long double slack_in_long_double(const Shell& shell, Vec3d p) {
  long double inside = value_in_long_double(shell.form.base, p);
  if (shell.kind == ShellKind::soft) {
    for (const Perturbation& r : shell.form.perturbations) {
      const long double q = std::max(0.0L, value_in_long_double(r.form.base, p));
      inside += static_cast<long double>(r.strength) * q * q;
    }
    return inside;
  }
  for (const Perturbation& r : shell.form.perturbations) {  // fitted shells have dents only
    inside = std::min(inside, -value_in_long_double(r.form.base, p));
  }
  return inside;
}

/// Points outside among 27 of each occupied cell: corners, middles of edges and faces, the centre.
/// A point on far sides is left to the neighbour beyond them, if that is occupied.
std::uint64_t count_lost_points(const Shell& shell, const Support& support) {
  const ShellFrame to = frame(shell);
  std::atomic<std::uint64_t> lost = 0;
  tbb::parallel_for(support.lo.x, support.hi.x, [&](std::int64_t x) {
    for (std::int64_t y = support.lo.y; y < support.hi.y; ++y) {
      for (std::int64_t z = support.lo.z; z < support.hi.z; ++z) {
        if (!is_occupied(support, {x, y, z})) continue;
        for (int i = 0; i < 27; ++i) {
          const Vec3l half{i % 3, i / 3 % 3, i / 9};
          const Vec3l next{half.x / 2, half.y / 2, half.z / 2};
          if (next != Vec3l{} && is_occupied(support, Vec3l{x, y, z} + next)) continue;
          const Vec3d p = to.to_shell(Vec3d(Vec3l{x, y, z}) + Vec3d(half) * 0.5);
          if (!(slack_in_long_double(shell, p) >= 0)) ++lost;
        }
      }
    }
  });
  return lost;
}

/// A line through the box of the support, isotropic, from outside.
Ray line_through(const Box& box, std::uint64_t i) {
  Rng rng(7, i, 0);
  const auto [a, b] = rng.uniform2();
  const double z = 2 * double(a) - 1, phi = 2 * std::numbers::pi * double(b);
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  const Vec3d d{r * std::cos(phi), r * std::sin(phi), z};
  const auto [u, v] = rng.uniform2();
  const Vec3d through = box.lo + box.extent() * Vec3d(double(u), double(v), double(rng.uniform()));
  return {through - d * (1.5 * length(box.extent())), d};
}

/// Lines of which the first or the last occupied point is in none of the shell's spans.
std::uint64_t count_lost_lines(const Shell& shell, const Support& support, std::uint64_t lines) {
  const RayShell rays(shell);
  const Box box{Vec3d(support.lo), Vec3d(support.hi)};
  constexpr double kRounding = 1e-9;  // of the traversal's t, in cells
  std::atomic<std::uint64_t> lost = 0;
  tbb::parallel_for(std::uint64_t(0), lines / 1000, [&](std::uint64_t batch) {
    std::vector<Span> spans;
    for (std::uint64_t i = 1000 * batch; i < 1000 * (batch + 1); ++i) {
      const Ray ray = line_through(box, i);
      const auto occupied = first_and_last(support, ray);
      if (!occupied) continue;
      rays.intersect(ray, 0, std::numeric_limits<double>::infinity(), spans);
      const bool held = !spans.empty() && spans.front().t0 <= occupied->t0 + kRounding &&
                        spans.back().t1 >= occupied->t1 - kRounding;
      if (!held || rays.misses(ray, 0, std::numeric_limits<double>::infinity())) ++lost;
    }
  });
  return lost;
}

TEST_P(ShellOfCloud, IsTightAndLosesNothing) {
  const std::filesystem::path file = std::filesystem::path(PVOL_SHARED_DATA) / GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const bool every_time = GetParam().ratio_of_few > 0;
  if (!proof::runs_all() && !every_time) GTEST_SKIP() << "tests/nightly fits the other shells";
  const formats::LoadedGrid loaded = formats::load_grid(file, {GetParam().grid, false});
  const Support support = make_support(loaded.grid, build_pyramid(loaded.grid));
  const bool few = !proof::runs_all();
  const Shell shell = fit_shell(support, {GetParam().kind, few ? 6 : 16});
  EXPECT_LE(shell.tightness.volume_ratio, few ? GetParam().ratio_of_few : GetParam().volume_ratio);
  EXPECT_GE(shell.tightness.volume_ratio, 1);
  EXPECT_LT(shell.tightness.hit_ratio, 1.25);
  EXPECT_EQ(count_lost_points(shell, support), 0u);
  EXPECT_EQ(count_lost_lines(shell, support, proof::samples(1'000'000)), 0u);
}

INSTANTIATE_TEST_SUITE_P(
    Clouds, ShellOfCloud,
    testing::Values(Case{"synthetic_cumulus.vdb", "density", ShellKind::hard, 1.50},
                    Case{"wdas_cloud_sixteenth.vdb", "density", ShellKind::hard, 1.52, 1.69},
                    Case{"wdas_cloud_sixteenth.vdb", "density", ShellKind::soft, 1.53},
                    Case{"embergen_fire_a_75.vdb", "flames", ShellKind::hard, 2.42},
                    Case{"smoke1.vdb", "density", ShellKind::hard, 1.34}),
    [](const auto& test) {
      const std::string stem = std::filesystem::path(test.param.file).stem().string();
      return stem + "_" + test.param.grid +
             (test.param.kind == ShellKind::soft ? "_soft" : "_hard");
    });

}  // namespace shell_clouds_test
}  // namespace pvol
