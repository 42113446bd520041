// The tricubic look-up, its leaves' bounds and its micro-bounds against the definition in double.
#include "pvol/field/tricubic.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>

#include "pvol/bounds/statistics.h"
#include "pvol/error.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/field/micro_range.h"
#include "pvol/render/render.h"
#include "pvol/shell/support.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/nasty_offset.h"
#include "support/oracle.h"

namespace pvol::test {
namespace tricubic_test {

constexpr auto kTricubic = LookUp::tricubic;
constexpr int kEdge = field_edge(kTricubic), kCount = field_samples(kTricubic);
constexpr std::uint64_t kSeed = 20260101;

using Value = std::function<float(Rng&)>;
const std::vector<Value>& values() {
  static const std::vector<Value> all{
      [](Rng& r) { return r.uniform(); },
      [](Rng& r) { return 1 + 0x1p-23f * std::floor(4 * r.uniform()); },  // a few ulp apart
      [](Rng& r) { return std::exp2(-140 * r.uniform()); },               // down to subnormals
      [](Rng& r) { return 0x1p-149f * std::floor(9 * r.uniform()); },
      [](Rng& r) { return r.uniform() < 0.9f ? 1e-6f : 1.0f; },
      [](Rng& r) { return FLT_MAX * r.uniform(); },
      [](Rng& r) { return r.uniform() < 0.02f ? r.uniform() : 0; },
  };
  return all;
}

/// Bricks of samples by `value`, the first of them zero as in every field.
BrickField random_bricks(int bricks, std::uint64_t stream, const Value& value) {
  BrickField f;
  f.look_up = kTricubic;
  f.samples.assign(std::size_t(kCount), 0.0f);
  Rng rng(kSeed, stream, 0);
  for (int i = 0; i < bricks * kCount; ++i) f.samples.push_back(value(rng));
  return f;
}

/// The 11^3 samples of a brick as a field: lattice point (0, 0, 0) is its first cell.
Field as_field(const float* samples) {
  return make_field("brick", {-1, -1, -1}, {kEdge, kEdge, kEdge}, [&](Vec3i p) {
    const Vec3i at = p + Vec3i(1);
    return double(samples[(at.x * kEdge + at.y) * kEdge + at.z]);
  });
}

float look_up(const float* brick, Vec3i cell, Float4 offset) {
  return density_in_brick<kTricubic>(brick, {widen(cell), offset});
}

/// (T1.4): 2^-17 of the largest sample off the exact value, 6 ulp off the hull, never below 0.
TEST(Tricubic, IsTheSplineAndStaysInTheHull) {
  for (std::size_t v = 0; v < values().size(); ++v) {
    const BrickField f = random_bricks(1, v, values()[v]);
    const Field exact = as_field(f.brick<kTricubic>(1));
    Rng rng(kSeed, v, 1);
    double worst = 0;
    for (int i = 0; i < 20'000; ++i) {
      const Vec3i cell(i % 8, i / 8 % 8, i / 64 % 8);
      const Float4 offset = nasty_offsets(rng);
      float lo = FLT_MAX, hi = 0;
      for (int k = 0; k < 64; ++k) {
        const float s = exact.at(cell + Vec3i(k / 16 - 1, k / 4 % 4 - 1, k % 4 - 1));
        lo = std::min(lo, s), hi = std::max(hi, s);
      }
      // At an offset of 1 the place is the next cell's too, where the spline is the same.
      const Vec3d p = Vec3d(cell) + Vec3d(vec3(offset));
      const double rho = double(look_up(f.brick<kTricubic>(1), cell, offset));
      const double tiny = 64 * double(FLT_TRUE_MIN);
      const double error = std::abs(rho - density_at(exact, kTricubic, p));
      worst = std::max(worst, (error - tiny) / double(hi));
      const double slack = std::max(double(hi) * 6 * 0x1p-23, tiny);
      ASSERT_TRUE(rho >= 0 && rho >= double(lo) - slack && rho <= double(hi) + slack) << rho;
    }
    EXPECT_LT(worst, 0x1p-17) << v;
  }
}

TEST(Tricubic, ReproducesWhatSplinesReproduce) {
  const auto brick_of = [](const auto& value) {
    std::vector<float> s;
    for (int i = 0; i < kCount; ++i) {
      s.push_back(float(value(Vec3d(i / kEdge / kEdge - 1, i / kEdge % kEdge - 1, i % kEdge - 1))));
    }
    return s;
  };
  const auto linear = [](Vec3d p) { return 3 + 0.5 * p.x + 0.25 * p.y + 0.125 * p.z; };
  const auto spike = [](Vec3d p) { return double(p == Vec3d(4, 3, 2)); };
  const std::vector<float> plane = brick_of(linear), delta = brick_of(spike);
  const std::vector<float> flat = brick_of([](Vec3d) { return 0.7; });
  Rng rng(kSeed, 100, 0);
  for (int i = 0; i < 10'000; ++i) {
    const Vec3i cell(i % 8, i / 8 % 8, i / 64 % 8);
    const Float4 offset = nasty_offsets(rng);
    const Vec3d p = Vec3d(cell) + Vec3d(vec3(offset));
    ASSERT_NEAR(double(look_up(plane.data(), cell, offset)), linear(p), 11 * 0x1p-20);
    ASSERT_EQ(look_up(flat.data(), cell, offset), 0.7f);
  }
  // The kernel in closed form: 4/6 at its knot, 1/6 at the next, 23/48 halfway.
  const auto at = [&](Vec3i cell, float x) {
    return double(look_up(delta.data(), cell, Float4{x, 0, 0, 0}));
  };
  constexpr double kPeak = 4.0 / 6 * 4 / 6;  // along the two other axes
  EXPECT_NEAR(at({4, 3, 2}, 0), kPeak * 4 / 6, 1e-6);
  EXPECT_NEAR(at({5, 3, 2}, 0), kPeak / 6, 1e-6);
  EXPECT_NEAR(at({3, 3, 2}, 0), kPeak / 6, 1e-6);
  EXPECT_NEAR(at({4, 3, 2}, 0.5f), kPeak * 23 / 48, 1e-6);
  EXPECT_NEAR(at({2, 3, 2}, 0.5f), kPeak / 48, 1e-6);
  EXPECT_EQ(at({2, 3, 2}, 0), 0);
  EXPECT_EQ(at({6, 3, 2}, 0), 0);
}

/// The extremes of all samples that cells of the box read.
std::pair<float, float> extremes(const Field& f, Vec3i cell, int edge) {
  float lo = FLT_MAX, hi = 0;
  for (int x = -1; x < edge + 2; ++x) {
    for (int y = -1; y < edge + 2; ++y) {
      for (int z = -1; z < edge + 2; ++z) {
        const float s = f.at(cell + Vec3i(x, y, z));
        lo = std::min(lo, s), hi = std::max(hi, s);
      }
    }
  }
  return {lo, hi};
}

/// The leaf or uniform cube that holds a leaf's place, if there is one.
const PyramidNode* terminal_at(const Pyramid& p, Vec3i leaf) {
  const Vec3l d = Vec3l(leaf) - p.origin;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const int shift = 3 + int(level);
    const Vec3<std::uint32_t> cube(Vec3l(d.x >> shift, d.y >> shift, d.z >> shift));
    const auto i = find(p.levels[level], morton_encode(cube));
    if (i && (level == 0 || is_uniform(p, level, *i))) return &p.levels[level][*i];
  }
  return nullptr;
}

/// Every 8^3 cells of every test field: bounds are the codes next to the extremes of all 11^3
/// samples, and what lies in no leaf reads zeros alone.
TEST(TricubicBounds, AreThoseOfAllSamplesInReach) {
  for (const Field& f : fields()) {
    const Pyramid p = build_pyramid(f.grid, kTricubic);
    ASSERT_EQ(validate(p), std::nullopt) << f.name;
    EXPECT_EQ(p.look_up, kTricubic);
    const auto floor8 = [](Vec3i v) { return Vec3i(v.x & -8, v.y & -8, v.z & -8); };
    const Vec3i first = floor8(f.origin - Vec3i(2)), last = f.origin + f.size + Vec3i(1);
    int wrong = 0;
    for (int x = first.x; x <= last.x; x += 8) {
      for (int y = first.y; y <= last.y; y += 8) {
        for (int z = first.z; z <= last.z; z += 8) {
          const auto [lo, hi] = extremes(f, {x, y, z}, 8);
          const bool inside = min(Vec3l(x, y, z), p.origin) == p.origin;
          const PyramidNode* node = inside ? terminal_at(p, {x, y, z}) : nullptr;
          if (node == nullptr) {
            wrong += hi != 0;
          } else {
            wrong += node->lo != decode(encode_down(lo, p.scale), p.scale) ||
                     node->hi != decode(encode_up(hi, p.scale), p.scale);
          }
        }
      }
    }
    EXPECT_EQ(wrong, 0) << f.name;
  }
}

/// Support, to the cell, and mass: the spline spreads samples but neither adds nor loses any.
TEST(TricubicBounds, HaveTheSupportAndTheMassOfTheSpline) {
  for (const char* name : {"one_voxel_on_a_border", "sparse", "tiles_8", "gaussian"}) {
    const Field& f = field(name);
    const Pyramid p = build_pyramid(f.grid, kTricubic);
    const Support s = make_support(f.grid, p);
    EXPECT_EQ(s.lo, p.support_lo) << name;
    EXPECT_EQ(s.hi, p.support_hi) << name;
    int wrong = 0;
    const Vec3i first = f.origin - Vec3i(3), last = f.origin + f.size + Vec3i(2);
    for (int x = first.x; x <= last.x; ++x) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int z = first.z; z <= last.z; ++z) {
          wrong += is_occupied(s, {x, y, z}) != (extremes(f, {x, y, z}, 1).second > 0);
        }
      }
    }
    EXPECT_EQ(wrong, 0) << name;
    const PyramidContent content = measure_content(f.grid, p);
    EXPECT_NEAR(content.back()[0].mass, f.sum, 1e-5 * f.sum) << name;
  }
}

/// How many of many look-ups, spread over all bricks, leave their micro-bounds.
int violations(const BrickField& f, const MicroBounds& m) {
  Rng rng(kSeed, std::uint64_t(m.edge), 7);
  int wrong = 0;
  for (std::size_t b = 0; b < f.bricks(); ++b) {
    for (int i = 0; i < 8 * 512; ++i) {
      const Vec3i cell((i >> 6) & 7, (i >> 3) & 7, i & 7);
      const auto brick = std::uint32_t(b);
      const DensityRange r = micro_range(m, brick, widen(cell));
      const float rho = look_up(f.brick<kTricubic>(brick), cell, nasty_offsets(rng));
      wrong += !(r.lo <= rho && rho <= r.hi);
    }
  }
  return wrong;
}

TEST(TricubicMicroBounds, HoldForEveryLookupToTheLastBit) {
  for (std::size_t i = 0; i < values().size(); ++i) {
    const BrickField f = random_bricks(10, 20 + i, values()[i]);
    for (const int edge : {1, 2}) {
      const MicroBounds m = build_micro_bounds(f, edge);
      EXPECT_TRUE(hold(m, f));
      EXPECT_EQ(violations(f, m), 0) << i;
    }
  }
}

/// On a smooth field Bernstein coefficients leave little between them and the spline, while the
/// hull of 4^3 samples is three times as wide.
TEST(TricubicMicroBounds, AreFarTighterThanTheHull) {
  const Field& f = field("gaussian");
  const FieldWithLinks linked =
      build_field(f.grid, build_pyramid(f.grid, kTricubic), {.look_up = kTricubic});
  const MicroBounds m = build_micro_bounds(linked.field, 1);
  double width = 0, hull = 0, truth = 0, code = 0;
  for (std::uint32_t b = 1; b < linked.field.bricks(); ++b) {
    const Field brick = as_field(linked.field.brick<kTricubic>(b));
    for (int i = 0; i < 512; ++i) {
      const Vec3i cell(i >> 6, i >> 3 & 7, i & 7);
      const DensityRange r = micro_range(m, b, widen(cell));
      width += double(r.hi - r.lo), code += double(m.scales[b].step);
      const auto [lo, hi] = extremes(brick, cell, 1);
      hull += double(hi - lo);
      double least = 1e9, most = 0;
      for (int c = 0; c < 27; ++c) {
        const Vec3d p = Vec3d(cell) + Vec3d(c / 9, c / 3 % 3, c % 3) * 0.5;
        const double rho = density_at(brick, kTricubic, p);
        least = std::min(least, rho), most = std::max(most, rho);
      }
      truth += most - least;
    }
  }
  EXPECT_LT(width, 0.5 * hull);
  EXPECT_LT(width, 1.1 * truth + 2 * code);
}

TEST(TricubicMicroBounds, ThatDoNotHoldAreFoundAndThreadsDoNotMatter) {
  const BrickField f = random_bricks(100, 40, values()[0]);
  const MicroBounds good = build_micro_bounds(f, 2);
  const auto breaks = [&](const auto& change) {
    MicroBounds bad = good;
    change(bad);
    EXPECT_FALSE(hold(bad, f));
  };
  breaks([](MicroBounds& m) { ++m.codes[100].lo; });
  breaks([](MicroBounds& m) { --m.codes[100].hi; });
  breaks([](MicroBounds& m) { m.codes.pop_back(); });
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(good, build_micro_bounds(f, 2));
}

TEST(TricubicBounds, AreAskedForAndRefusedWhereTheyDoNotHold) {
  const Field& f = field("gaussian");
  const Pyramid narrow = build_pyramid(f.grid), wide = build_pyramid(f.grid, kTricubic);
  CloudScene s;
  EXPECT_NO_THROW((void)make_volume(f.grid, wide, s));  // holds for trilinear look-ups too
  s.options.look_up = kTricubic;
  EXPECT_NO_THROW((void)make_volume(f.grid, wide, s));
  try {
    (void)make_volume(f.grid, narrow, s);
    FAIL();
  } catch (const Error& e) {
    EXPECT_TRUE(says(e.what(), "interpolation.bounds_made_trilinear")) << e.what();
  }
  Pyramid forged = narrow;  // the bounds of the other kernel under a false name
  forged.look_up = kTricubic;
  EXPECT_THROW((void)make_volume(f.grid, forged, s), Error);
  s.options.look_up = LookUp::procedural;
  EXPECT_THROW((void)make_volume(f.grid, wide, s), Error);
  EXPECT_THROW((void)build_pyramid(f.grid, LookUp::procedural), Error);
}

}  // namespace tricubic_test
}  // namespace pvol::test
