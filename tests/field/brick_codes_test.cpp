// What the codes of a brick tell of its parts, against its samples.
#include "field/brick_codes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <functional>
#include <vector>

#include "support/fields.h"
#include "support/nasty_offset.h"
#include "support/random_bricks.h"

namespace pvol::test {
namespace brick_codes_test {

using Value = std::function<float(Rng&)>;

/// With and without zeros, and at the ends of what floats can be.
const std::vector<Value>& values() {
  static const std::vector<Value> all{
      [](Rng& r) { return r.uniform(); },
      [](Rng& r) { return r.uniform() < 0.6f ? 0 : r.uniform(); },
      [](Rng& r) { return r.uniform() < 0.6f ? 0 : std::exp2(-149 * r.uniform()); },
      [](Rng& r) { return r.uniform() < 0.6f ? 0 : FLT_MAX * r.uniform(); },
      [](Rng& r) { return r.uniform() < 0.98f ? 0 : 0x1p-149f; },
      [](Rng& r) { return r.uniform() < 0.5f ? 0 : 1; },
      [](Rng& r) { return 2 + r.uniform(); },
      [](Rng&) { return 0.7f; },
      [](Rng&) { return 0; },
  };
  return all;
}

TEST(BrickCodes, ZeroStandsForZeroAlone) {
  for (std::size_t v = 0; v < values().size(); ++v) {
    const BrickField f = random_bricks(10, v, values()[v]);
    for (std::uint32_t b = 0; b < f.bricks(); ++b) {
      std::array<std::uint8_t, kFieldSamples> codes;
      const SampleCodes::Scale scale = detail::code_samples(f.brick(b), codes.data());
      const bool has_zeros =
          std::find(f.brick(b), f.brick(b) + kFieldSamples, 0.0f) != f.brick(b) + kFieldSamples;
      EXPECT_EQ(scale.base < 0, has_zeros) << v;
      for (std::size_t i = 0; i < kFieldSamples && has_zeros; ++i) {
        ASSERT_EQ(codes[i] == 0, f.brick(b)[i] == 0) << v << ", " << f.brick(b)[i];
      }
    }
  }
}

TEST(BrickCodes, OfPartsAreThoseThatLookUpsRead) {
  Rng rng(kSeed, 31, 0);
  std::array<std::uint8_t, kFieldSamples> codes;
  for (std::uint8_t& c : codes) c = std::uint8_t(256 * rng.uniform());
  std::array<detail::CodeRange, 64> ranges;
  detail::find_code_ranges(codes.data(), ranges);
  for (int part = 0; part < 64; ++part) {
    const Vec3i low = Vec3i(part >> 4, part >> 2 & 3, part & 3) * 2;
    int lo = 255, hi = 0;
    for (int i = 0; i < 27; ++i) {
      const Vec3i at = low + Vec3i(i / 9, i / 3 % 3, i % 3);
      const int code = codes[std::size_t((at.x * kFieldEdge + at.y) * kFieldEdge + at.z)];
      lo = std::min(lo, code), hi = std::max(hi, code);
    }
    EXPECT_EQ(ranges[std::size_t(part)].lo, lo) << part;
    EXPECT_EQ(ranges[std::size_t(part)].hi, hi) << part;
  }
}

/// Of every part, whatever look-ups compute in it; parts of zeros are known to be 0, and no range
/// is wider than the samples' by more than a step and a bit at each end.
TEST(BrickCodes, ReachWhatLookUpsCompute) {
  for (std::size_t v = 0; v < values().size(); ++v) {
    const BrickField f = random_bricks(6, 40 + v, values()[v]);
    Rng rng(kSeed, 50 + v, 0);
    for (std::uint32_t b = 0; b < f.bricks(); ++b) {
      std::array<std::uint8_t, kFieldSamples> codes;
      const SampleCodes::Scale scale = detail::code_samples(f.brick(b), codes.data());
      std::array<detail::CodeRange, 64> ranges;
      detail::find_code_ranges(codes.data(), ranges);
      // The whole is what its parts are together, to the bit.
      const DensityRange whole =
          detail::reach_of_codes(scale, detail::find_code_range(codes.data()));
      DensityRange together = detail::reach_of_codes(scale, ranges[0]);
      for (const detail::CodeRange& part : ranges) {
        const DensityRange r = detail::reach_of_codes(scale, part);
        together = {std::min(together.lo, r.lo), std::max(together.hi, r.hi)};
      }
      ASSERT_EQ(whole.lo, together.lo) << v;
      ASSERT_EQ(whole.hi, together.hi) << v;
      for (int i = 0; i < 8 * 512; ++i) {
        const LatticePoint p{Int4{(i >> 6) & 7, (i >> 3) & 7, i & 7, 0},
                             Float4{nasty_offset(rng), nasty_offset(rng), nasty_offset(rng), 0}};
        const std::size_t part =
            std::size_t(((p.cell[0] >> 1) * 4 + (p.cell[1] >> 1)) * 4 + (p.cell[2] >> 1));
        const DensityRange r = detail::reach_of_codes(scale, ranges[part]);
        const float rho = density_in_brick<LookUp::trilinear>(f.brick(b), p);
        ASSERT_TRUE(r.lo <= rho && rho <= r.hi) << v << ": " << rho;
        const float width = float(ranges[part].hi - ranges[part].lo);
        ASSERT_LE(r.hi - r.lo, (width + 1.02f) * scale.step) << v;
        if (ranges[part].hi == 0 && scale.base < 0) {
          ASSERT_EQ(r.hi, 0.0f) << v;
        }
      }
    }
  }
}

}  // namespace brick_codes_test
}  // namespace pvol::test
