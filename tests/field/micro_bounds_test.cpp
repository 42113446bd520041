// Micro-bounds against every density that look-ups can compute, and the squeeze, by them and by
// codes of samples, against plain tracking.
#include "pvol/field/micro_bounds.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>

#include "pvol/error.h"
#include "pvol/track/transmittance.h"
#include "support/flights.h"
#include "support/nasty_offset.h"
#include "support/random_bricks.h"

namespace pvol::test {
namespace micro_bounds_test {

/// How many of many look-ups, spread over all bricks, leave their micro-bounds.
int violations(const BrickField& f, int edge, std::uint64_t stream) {
  const MicroBounds m = build_micro_bounds(f, edge);
  EXPECT_TRUE(hold(m, f));
  Rng rng(kSeed, stream, std::uint64_t(edge));
  int wrong = 0;
  for (std::size_t b = 0; b < m.scales.size(); ++b) {
    for (int i = 0; i < 8 * 512; ++i) {
      const Int4 cell{(i >> 6) & 7, (i >> 3) & 7, i & 7, 0};
      const LatticePoint p{cell,
                           Float4{nasty_offset(rng), nasty_offset(rng), nasty_offset(rng), 0}};
      const auto brick = std::uint32_t(b);
      const DensityRange r = micro_range(m, brick, cell);
      for (const float rho : {density_in_brick<LookUp::trilinear>(f.brick(brick), p),
                              density_in_brick<LookUp::nearest>(f.brick(brick), p)}) {
        wrong += !(r.lo <= rho && rho <= r.hi);
      }
    }
  }
  return wrong;
}

TEST(MicroBounds, HoldForEveryLookupToTheLastBit) {
  using Value = std::function<float(Rng&)>;
  const std::vector<Value> values{
      [](Rng& r) { return r.uniform(); },
      [](Rng& r) { return 1 + 0x1p-23f * std::floor(4 * r.uniform()); },  // a few ulp apart
      [](Rng& r) { return r.uniform() < 0.5f ? 1 : 0x1.fffffep-1f; },     // about a power of two
      [](Rng& r) { return std::exp2(-140 * r.uniform()); },               // down to subnormals
      [](Rng& r) { return 0x1p-149f * std::floor(9 * r.uniform()); },
      [](Rng& r) { return r.uniform() < 0.9f ? 1e-6f : 1.0f; },
      [](Rng& r) { return FLT_MAX * r.uniform(); },
      [](Rng& r) { return r.uniform() < 0.02f ? r.uniform() : 0; },
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const BrickField f = random_bricks(20, i, values[i]);
    EXPECT_EQ(violations(f, 1, i), 0) << i;
    EXPECT_EQ(violations(f, 2, i), 0) << i;
  }
}

/// Both ends within a code, and a few ulp, of the samples' extremes.
TEST(MicroBounds, AreTight) {
  const BrickField f =
      random_bricks(50, 1, [](Rng& r) { return 0.3f + r.uniform() * r.uniform(); });
  const MicroBounds m = build_micro_bounds(f, 2);
  for (std::size_t b = 1; b < m.scales.size(); ++b) {
    const float* samples = f.brick(std::uint32_t(b));
    const float tolerance = m.scales[b].step + 0x1p-20f;
    EXPECT_LT(m.scales[b].step * 255, 1.01f);
    for (int cube = 0; cube < 64; ++cube) {
      const Vec3i low(2 * (cube >> 4), 2 * (cube >> 2 & 3), 2 * (cube & 3));
      float least = FLT_MAX, most = 0;
      for (int i = 0; i < 27; ++i) {
        const Vec3i at = low + Vec3i(i / 9, i / 3 % 3, i % 3);
        const float v = samples[(at.x * kFieldEdge + at.y) * kFieldEdge + at.z];
        least = std::min(least, v), most = std::max(most, v);
      }
      const DensityRange r = micro_range(m, std::uint32_t(b), widen(low));
      EXPECT_TRUE(least - tolerance < r.lo && r.hi < most + tolerance) << r.lo << " " << r.hi;
    }
  }
}

TEST(MicroBounds, AreExactWhereABrickIsConstant) {
  BrickField f;
  f.samples.assign(kFieldSamples, 0.0f);
  f.samples.insert(f.samples.end(), kFieldSamples, 0.7f);
  for (const int edge : {1, 2}) {
    const MicroBounds m = build_micro_bounds(f, edge);
    const DensityRange zero = micro_range(m, 0, Int4{}), one = micro_range(m, 1, Int4{});
    EXPECT_TRUE(zero.lo == 0 && zero.hi == 0 && one.lo == 0.7f && one.hi == 0.7f);
  }
}

/// Where steps are so small that codes share densities, too.
TEST(MicroBounds, KeepTheirCodesInOrder) {
  const BrickField f = random_bricks(20, 4, [](Rng& r) {
    const float u = r.uniform();
    return u < 0.5f ? 1 : u < 0.9f ? 1 - 0x1p-22f : 1 - 0x1p-20f * r.uniform();
  });
  for (const int edge : {1, 2}) {
    for (const MicroBounds::Codes c : build_micro_bounds(f, edge).codes) ASSERT_LE(c.lo, c.hi);
  }
}

TEST(MicroBounds, DoNotDependOnThreads) {
  const BrickField f = random_bricks(300, 2, [](Rng& r) { return r.uniform(); });
  const MicroBounds many = build_micro_bounds(f, 1);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, build_micro_bounds(f, 1));
}

TEST(MicroBounds, ThatDoNotHoldAreFound) {
  const BrickField f = random_bricks(3, 3, [](Rng& r) { return r.uniform(); });
  const MicroBounds good = build_micro_bounds(f, 2);
  const auto breaks = [&](const auto& change) {
    MicroBounds bad = good;
    change(bad);
    EXPECT_FALSE(hold(bad, f));
  };
  breaks([](MicroBounds& m) { ++m.codes[100].lo; });
  breaks([](MicroBounds& m) { --m.codes[100].hi; });
  breaks([](MicroBounds& m) { m.scales[2].base += 0.1f; });
  breaks([](MicroBounds& m) { m.scales[2].step = std::nanf(""); });
  breaks([](MicroBounds& m) { m.codes.pop_back(); });
  breaks([](MicroBounds& m) { m.scales.emplace_back(); });
  breaks([](MicroBounds& m) { m.edge = 3; });
  EXPECT_THROW((void)build_micro_bounds(f, 3), Error);
}

/// All that can decide collisions in a volume's bricks.
struct Squeezes {
  MicroBounds single, cubes;
  SampleCodes codes;

  explicit Squeezes(const Volume& v)
      : single(build_micro_bounds(v.density.bricks(), 1)),
        cubes(build_micro_bounds(v.density.bricks(), 2)),
        codes(build_sample_codes(v.density.bricks())) {}
};

struct Saving {
  std::uint64_t plain = 0, squeezed = 0;  // look-ups
};

/// The same flights with and without a squeeze: equal to the last bit, as are the random numbers
/// that follow.
template <Tracker kTracker, LookUp kLookUp, class Bounds>
void compare(const Volume& v, const Aim& a, int flights, const Bounds& bounds, Saving& saving) {
  const BrickExtinction<kLookUp> source{v.density.bricks(), v.density.octree, v.density.scale};
  const PlainField plain{source};
  const SqueezedField<Bounds, BrickExtinction<kLookUp>> squeezed{source, bounds};
  int different = 0;
  for (int i = 0; i < flights; ++i) {
    Rng rng(kSeed, 5, std::uint64_t(i)), same = rng;
    Walk walk(v.density.octree, a.cursor, a.direction), again = walk;
    Tally tally, fewer;
    const Flight f = free_flight<kTracker>(walk, plain, rng, tally);
    const Flight g = free_flight<kTracker>(again, squeezed, same, fewer);
    different += !(f.collided == g.collided && f.t == g.t && g.weight == 1);
    different += tally.null_collisions != fewer.null_collisions;
    different += rng.block().lo != same.block().lo;
    EXPECT_LE(fewer.lookups, tally.lookups);
    saving.plain += tally.lookups, saving.squeezed += fewer.lookups;
  }
  EXPECT_EQ(different, 0);
}

template <LookUp kLookUp>
void compare_all() {
  for (const Field& f : fields()) {
    SCOPED_TRACE(f.name);
    Saving single, cubes, codes;
    for (const std::optional<int> depth : {std::optional<int>(16), std::optional<int>(1)}) {
      const Volume v = make_test_volume(f, 1, depth);
      const Squeezes of(v);
      for (int ray = 0; ray < kRays; ++ray) {
        const Aim a = aim(f, v, kLookUp, ray, 2);
        const auto compare_both = [&](const auto& bounds, Saving& saving) {
          compare<Tracker::delta, kLookUp>(v, a, 1000, bounds, saving);
          compare<Tracker::decomposition, kLookUp>(v, a, 1000, bounds, saving);
        };
        compare_both(CubeBounds{of.single}, single);
        compare_both(CubeBounds{of.cubes}, cubes);
        compare_both(CodeBounds<kLookUp>{of.codes}, codes);
      }
    }
    EXPECT_LE(single.squeezed, cubes.squeezed);
    EXPECT_LE(codes.squeezed, single.squeezed + single.plain / 100);
  }
}

TEST(Squeeze, IsBitIdenticalToPlainTrilinearTracking) { compare_all<LookUp::trilinear>(); }
TEST(Squeeze, IsBitIdenticalToPlainNearestTracking) { compare_all<LookUp::nearest>(); }

/// A volume whose walks stop at leaves, not at parts of them.
Volume volume_of_leaves(const Field& f) {
  const auto is_part = [](const Octree::Entry& e) {
    return e.log2 > 0 && (1 << e.log2) < kBrickEdge;
  };
  for (int depth = 16;; --depth) {
    Volume v = make_test_volume(f, 1, depth);
    if (std::ranges::none_of(v.density.octree.entries, is_part)) return v;
  }
}

/// Of 253 tentative collisions codes leave one open at most, whatever the field: under majorants of
/// leaves. Of parts of leaves these are lower, and more stays open.
TEST(Squeeze, ByCodesSavesNearlyAllLookups) {
  for (const char* const name : {"gaussian", "sparse"}) {
    const Field& f = field(name);
    const Volume v = volume_of_leaves(f);
    const Aim a = aim(f, v, LookUp::trilinear, 0, 3);
    const Squeezes of(v);
    Saving codes;
    compare<Tracker::delta, LookUp::trilinear>(v, a, 20'000,
                                               CodeBounds<LookUp::trilinear>{of.codes}, codes);
    EXPECT_LT(double(codes.squeezed), 0.006 * double(codes.plain)) << name;
    EXPECT_GT(codes.plain, 20'000u);
  }
}

/// A smooth field: cells span little of a leaf's range, and few decisions stay open.
TEST(Squeeze, SavesMostLookupsOnSmoothFields) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, 16);
  const Aim a = aim(f, v, LookUp::trilinear, 0, 3);
  const Squeezes of(v);
  Saving single, cubes;
  compare<Tracker::delta, LookUp::trilinear>(v, a, 20'000, CubeBounds{of.single}, single);
  compare<Tracker::delta, LookUp::trilinear>(v, a, 20'000, CubeBounds{of.cubes}, cubes);
  EXPECT_LT(double(single.squeezed), 0.3 * double(single.plain));
  EXPECT_LT(double(cubes.squeezed), 0.5 * double(cubes.plain));
}

/// Exactly, also where the threshold is the density or one of its bounds.
TEST(Squeeze, DecidesAsTheLookUpDoes) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, 16);
  const MicroBounds m = build_micro_bounds(v.density.bricks(), 1);
  const BrickExtinction<LookUp::trilinear> source{v.density.bricks(), v.density.octree,
                                                  v.density.scale};
  const PlainField plain{source};
  const SqueezedField<CubeBounds, BrickExtinction<LookUp::trilinear>> squeezed{source, {m}};
  Tally tally;
  std::uint64_t questions = 0;
  for (int i = 0; i < 20; ++i) {
    const Aim a = aim(f, v, LookUp::trilinear, i, 3);
    Walk walk(v.density.octree, a.cursor, a.direction);
    while (const auto s = walk.next()) {
      const LatticePoint p = walk.point(0.5 * (s->t0 + s->t1));
      const DensityRange range = micro_range(m, source.brick(*s, p), p.cell);
      const float mu_t = plain.extinction(*s, p, tally);
      EXPECT_EQ(squeezed.extinction(*s, p, tally), mu_t);
      for (const float bound : {mu_t, source.scale * range.lo, source.scale * range.hi}) {
        for (const float mu : {bound, std::nextafter(bound, 0.0f), std::nextafter(bound, 1e30f)}) {
          EXPECT_EQ(plain.exceeds(*s, p, mu, tally), mu < mu_t);
          EXPECT_EQ(squeezed.exceeds(*s, p, mu, tally), mu < mu_t);
          ++questions;
        }
      }
    }
  }
  EXPECT_GT(questions, 100u);
}

/// Bounds tests: one for each tentative collision that delta tracking squeezes; with decomposition
/// one for the control part and one for the micro-bounds of those it left open.
TEST(Squeeze, CountsEachComparison) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, 16);
  const Aim a = aim(f, v, LookUp::trilinear, 0, 3);
  const MicroBounds m = build_micro_bounds(v.density.bricks(), 1);
  const BrickExtinction<LookUp::trilinear> source{v.density.bricks(), v.density.octree,
                                                  v.density.scale};
  const SqueezedField<CubeBounds, BrickExtinction<LookUp::trilinear>> squeezed{source, {m}};
  Tally plain, delta, decomposed, bare;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const auto fly = [&]<Tracker kTracker>(const auto& model, Tally& tally) {
      Rng rng(kSeed, 6, i);
      Walk walk(v.density.octree, a.cursor, a.direction);
      (void)free_flight<kTracker>(walk, model, rng, tally);
    };
    fly.operator()<Tracker::delta>(PlainField{source}, plain);
    fly.operator()<Tracker::decomposition>(PlainField{source}, bare);
    fly.operator()<Tracker::delta>(squeezed, delta);
    fly.operator()<Tracker::decomposition>(squeezed, decomposed);
  }
  const std::uint64_t tentative = plain.lookups;
  EXPECT_EQ(plain.bounds_tests, 0u);
  EXPECT_EQ(bare.bounds_tests, tentative);
  EXPECT_EQ(delta.bounds_tests, tentative);
  EXPECT_EQ(decomposed.bounds_tests, tentative + bare.lookups);
}

}  // namespace micro_bounds_test
}  // namespace pvol::test
