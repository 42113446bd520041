// Codes of samples against every density that look-ups can compute.
#include "pvol/field/sample_codes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>

#include "pvol/field/shared_field.h"
#include "support/fields.h"
#include "support/nasty_offset.h"
#include "support/random_bricks.h"

namespace pvol::test {
namespace sample_codes_test {

struct Found {
  int wrong = 0;       ///< densities that left their range
  float farthest = 0;  ///< from the middle of the range, in steps
};

/// Of many look-ups, spread over all bricks.
template <LookUp kLookUp>
Found look_up_all(const BrickField& f, std::uint64_t stream) {
  const SampleCodes codes = build_sample_codes(f);
  Rng rng(kSeed, stream, 1);
  Found found;
  for (std::uint32_t b = 0; b < codes.scales.size(); ++b) {
    for (int i = 0; i < 8 * 512; ++i) {
      const LatticePoint p{Int4{(i >> 6) & 7, (i >> 3) & 7, i & 7, 0},
                           Float4{nasty_offset(rng), nasty_offset(rng), nasty_offset(rng), 0}};
      const DensityRange r = code_range<kLookUp>(codes, b, p);
      const float rho = density_in_brick<kLookUp>(f.brick(b), p);
      found.wrong += !(r.lo <= rho && rho <= r.hi);
      if (b == 0) continue;
      const float middle = r.lo / 2 + r.hi / 2;
      found.farthest = std::max(found.farthest, std::abs(rho - middle) / codes.scales[b].step);
    }
  }
  return found;
}

TEST(SampleCodes, HoldForEveryLookupToTheLastBit) {
  using Value = std::function<float(Rng&)>;
  const std::vector<Value> values{
      [](Rng& r) { return r.uniform(); },
      [](Rng& r) { return 1 + 0x1p-23f * std::floor(4 * r.uniform()); },  // a few ulp apart
      [](Rng& r) { return r.uniform() < 0.5f ? 1 : 0x1.fffffep-1f; },     // about a power of two
      [](Rng& r) { return 1 + 0x1p-9f * r.uniform(); },  // steps that the largest sample asks for
      [](Rng& r) { return std::exp2(-140 * r.uniform()); },  // down to subnormals
      [](Rng& r) { return 0x1p-149f * std::floor(9 * r.uniform()); },
      [](Rng& r) { return r.uniform() < 0.9f ? 1e-6f : 1.0f; },
      [](Rng& r) { return FLT_MAX * r.uniform(); },
      [](Rng& r) { return r.uniform() < 0.02f ? r.uniform() : 0; },
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const BrickField f = random_bricks(20, i, values[i]);
    EXPECT_EQ(look_up_all<LookUp::trilinear>(f, i).wrong, 0) << i;
    EXPECT_EQ(look_up_all<LookUp::nearest>(f, i).wrong, 0) << i;
  }
}

/// The slack is half a step and little more, and look-ups use all of it: none could be smaller.
TEST(SampleCodes, AreAsTightAsBytesCanBe) {
  const BrickField f = random_bricks(50, 10, [](Rng& r) { return 0.3f + r.uniform(); });
  EXPECT_LT(kCodeSlack, 0.51f);
  EXPECT_GT(look_up_all<LookUp::nearest>(f, 10).farthest, 0.499f);
  EXPECT_GT(look_up_all<LookUp::trilinear>(f, 10).farthest, 0.47f);
  const SampleCodes codes = build_sample_codes(f);
  for (std::uint32_t b = 1; b < codes.scales.size(); ++b) {
    const auto [lo, hi] = std::minmax_element(f.brick(b), f.brick(b) + kFieldSamples);
    EXPECT_FLOAT_EQ(codes.scales[b].step, (*hi - *lo) / 255);
  }
}

/// Of a plateau that a ramp touches, or of none: steps are 2^-11 of the largest sample at least.
TEST(SampleCodes, OfNearlyEqualSamplesHaveStepsThatRoundingCannotReach) {
  const BrickField f = random_bricks(5, 11, [](Rng& r) { return 8 - 0x1p-12f * r.uniform(); });
  for (const SampleCodes::Scale s : build_sample_codes(f).scales) {
    EXPECT_TRUE(s.base < 0 || s.step >= 0x1p-8f * 0.999f) << s.step;
  }
}

TEST(SampleCodes, DoNotDependOnThreads) {
  const BrickField f = random_bricks(300, 12, [](Rng& r) { return r.uniform(); });
  const SampleCodes many = build_sample_codes(f);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, build_sample_codes(f));
}

/// Fields make them as they gather their samples, which may stay where they are.
TEST(SampleCodes, OfFieldsAreThoseOfTheirBricks) {
  for (const Field& field : fields()) {
    const Pyramid pyramid = build_pyramid(field.grid);
    const FieldWithLinks copied = build_field(field.grid, pyramid, {.codes = true});
    EXPECT_EQ(*copied.codes, build_sample_codes(copied.field)) << field.name;
    EXPECT_EQ(*copied.codes, *build_shared_field(field.grid, pyramid, {.codes = true}).codes)
        << field.name;
    EXPECT_EQ(build_field(field.grid, pyramid).codes, nullptr);
  }
}

}  // namespace sample_codes_test
}  // namespace pvol::test
