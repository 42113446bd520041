// Codes of densities against their definition, their error against what is found.
#include "pvol/density/quantise.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>
#include <map>

#include "pvol/error.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/math/rng.h"

namespace pvol {
namespace quantise_test {

using Value = std::function<float(Rng&)>;
constexpr Precision kCoded[] = {Precision::fp16, Precision::fp8, Precision::fpn};

/// Bricks in a row along x with samples by `value`, and a tile if its value is not 0.
VoxelGrid make_bricks(int bricks, std::uint64_t stream, const Value& value, float tile = 0) {
  const auto samples = std::make_shared<std::vector<float>>(std::size_t(bricks) * kBrickSamples);
  Rng rng(5, stream, 0);
  for (float& v : *samples) v = value(rng);
  VoxelGrid g;
  for (int b = 0; b < bricks; ++b) {
    g.bricks.push_back({{8 * b, 0, -8}, samples->data() + b * kBrickSamples});
  }
  if (tile > 0) g.tiles.push_back({{0, 8, 0}, 8, tile});
  g.owner = samples;
  return g;
}

const std::map<std::string, Value>& fields() {
  static const std::map<std::string, Value> all{
      {"uniform", [](Rng& r) { return r.uniform(); }},
      {"half empty", [](Rng& r) { return std::max(0.0f, r.uniform() - 0.5f); }},
      {"sparse", [](Rng& r) { return r.uniform() < 0.99f ? 0 : 3 * r.uniform(); }},
      {"wide", [](Rng& r) { return std::exp2(-140 * r.uniform()); }},
      {"subnormal", [](Rng& r) { return 0x1p-149f * std::floor(200 * r.uniform()); }},
      {"huge", [](Rng& r) { return FLT_MAX * r.uniform(); }},
      {"largest", [](Rng& r) { return r.uniform() < 0.5f ? FLT_MAX : 0; }},
      {"two values", [](Rng& r) { return r.uniform() < 0.5f ? 0.25f : 0.75f; }},
      {"plateau", [](Rng&) { return 0.3f; }},
      {"nearly a plateau", [](Rng& r) { return r.uniform() < 0.5f ? 1 : 0x1.fffffep-1f; }}};
  return all;
}

/// `f(exact samples, decoded samples, brick)` for each brick that is not of zeros.
template <class F>
void compare(const VoxelGrid& exact, const VoxelGrid& decoded, const F& f) {
  std::size_t found = 0;
  for (std::size_t b = 0; b < decoded.bricks.size(); ++b) {
    for (const Brick& e : exact.bricks) {
      if (!(e.origin == decoded.bricks[b].origin)) continue;
      f(e.values, decoded.bricks[b].values, b);
      ++found;
    }
  }
  EXPECT_EQ(found, decoded.bricks.size());
}

TEST(Quantise, KeepsTheSupportAndTheRange) {
  for (const auto& [field, value] : fields()) {
    for (const Precision p : kCoded) {
      SCOPED_TRACE(field + " " + name(p));
      const VoxelGrid g = make_bricks(6, 1, value);
      float largest = 0;
      for (const Brick& b : g.bricks) {
        largest = std::max(largest, *std::max_element(b.values, b.values + kBrickSamples));
      }
      int wrong = 0;
      compare(g, decode(quantise(g, {p})), [&](const float* v, const float* d, std::size_t) {
        const float top = *std::max_element(v, v + kBrickSamples);
        for (int i = 0; i < kBrickSamples; ++i) {
          wrong += (v[i] == 0) != (d[i] == 0) || !std::isfinite(d[i]) || d[i] < 0;
          wrong += p != Precision::fp16 && d[i] > top;
        }
      });
      EXPECT_EQ(wrong, 0);
    }
  }
}

TEST(Quantise, StatesTheErrorThatIsFound) {
  for (const auto& [field, value] : fields()) {
    for (const Precision p : kCoded) {
      SCOPED_TRACE(field + " " + name(p));
      const VoxelGrid g = make_bricks(6, 2, value, 0.125f);
      const QuantisedGrid q = quantise(g, {p});
      double absolute = 0, relative = 0, change = 0, mass = 512 * 0.125;
      compare(g, decode(q), [&](const float* v, const float* d, std::size_t) {
        for (int i = 0; i < kBrickSamples; ++i) {
          const double e = double(d[i]) - double(v[i]);
          absolute = std::max(absolute, std::abs(e));
          if (v[i] > 0) relative = std::max(relative, std::abs(e) / double(v[i]));
          change += e, mass += double(v[i]);
        }
      });
      EXPECT_EQ(q.error.absolute, absolute);
      EXPECT_EQ(q.error.relative, relative);
      EXPECT_NEAR(q.error.mass, change / mass, 1e-12 * (absolute / mass * 3072 + 1e-300));
    }
  }
}

/// Every half by its definition, as a table in ascending order.
std::vector<double> all_halves() {
  std::vector<double> h;
  for (int e = 0; e < 31; ++e) {
    for (int m = 0; m < 1024; ++m) {
      h.push_back(e == 0 ? m * std::pow(2.0, -24) : (1024 + m) * std::pow(2.0, e - 25));
    }
  }
  return h;
}

TEST(Quantise, HalvesAreTheNearestOnes) {
  const std::vector<double> halves = all_halves();
  for (std::size_t code = 0; code < halves.size(); code += 7) {
    EXPECT_EQ(double(decode_half(std::uint16_t(code), 0)), halves[code]);
    EXPECT_EQ(double(decode_half(std::uint16_t(code), -20)), halves[code] * 0x1p-20);
  }
  for (const char* field : {"uniform", "wide", "sparse"}) {
    const VoxelGrid g = make_bricks(6, 3, fields().at(field));
    const QuantisedGrid q = quantise(g, {Precision::fp16});
    const double unit = std::ldexp(1.0, q.exponent);
    int wrong = 0;
    compare(g, decode(q), [&](const float* v, const float* d, std::size_t) {
      for (int i = 0; i < kBrickSamples; ++i) {
        if (v[i] == 0) continue;
        const auto above = std::lower_bound(halves.begin(), halves.end(), double(v[i]) / unit);
        double nearest = above == halves.end() ? halves.back() : *above;
        if (above != halves.begin() &&
            double(v[i]) / unit - above[-1] < nearest - double(v[i]) / unit)
          nearest = above[-1];
        nearest = std::max(nearest, halves[1]);  // positive samples stay positive
        wrong += std::abs(double(d[i]) - double(v[i])) > std::abs(nearest * unit - double(v[i]));
      }
    });
    EXPECT_EQ(wrong, 0) << field;
  }
}

/// So that files of halves, as most are, lose nothing.
TEST(Quantise, HalvesOfHalvesAreExact) {
  for (const float largest : {65504.0f, 1.0f, 0x1p-14f, 0x1p-24f * 1023}) {
    const std::vector<double> halves = all_halves();
    const auto value = [&](Rng& r) { return float(halves[std::size_t(r.uniform() * 31743)]); };
    VoxelGrid g = make_bricks(4, 4, [&](Rng& r) { return std::min(largest, value(r)); });
    EXPECT_EQ(quantise(g, {Precision::fp16}).error, QuantisationError{}) << largest;
  }
}

/// The value nearest to v among those of a scale by its definition, in long double.
long double least_error(const QuantisedGrid::Scale& s, float v) {
  if (s.zero && v == 0) return 0;
  const int n = (1 << s.bits) - (s.zero ? 2 : 1);
  long double least = HUGE_VALL;
  for (int c = 0; c <= n; ++c) {
    const long double x =
        n == 0 ? s.lo : s.lo + c * ((long double)(s.hi) - (long double)(s.lo)) / n;
    least = std::min(least, std::abs(x - (long double)(v)));
  }
  return least;
}

TEST(Quantise, EightBitsAreTheNearestOfTheirScale) {
  for (const auto& [field, value] : fields()) {
    SCOPED_TRACE(field);
    const VoxelGrid g = make_bricks(3, 5, value);
    const QuantisedGrid q = quantise(g, {Precision::fp8});
    int wrong = 0;
    compare(g, decode(q), [&](const float* v, const float* d, std::size_t b) {
      float lo = FLT_MAX, hi = 0;
      for (int i = 0; i < kBrickSamples; ++i) {
        if (v[i] > 0) lo = std::min(lo, v[i]), hi = std::max(hi, v[i]);
      }
      EXPECT_TRUE(q.scales[b].lo == lo && q.scales[b].hi == hi && q.scales[b].bits == 8);
      for (int i = 0; i < kBrickSamples; ++i) {
        const double half_ulp = std::max(double(hi) * 0x1p-24, 0x1p-150);
        const double error = std::abs(double(d[i]) - double(v[i]));
        wrong += error > double(least_error(q.scales[b], v[i])) + half_ulp;
        wrong += error > (double(hi) - double(lo)) / 508 + half_ulp;
        wrong += v[i] == lo && d[i] != lo;
        wrong += v[i] == hi && d[i] != hi;
      }
    });
    EXPECT_EQ(wrong, 0);
  }
}

/// Within the tolerance, with no more bits than it takes.
TEST(Quantise, WidthsAreTheNarrowestWithinTheTolerance) {
  for (const char* field : {"uniform", "half empty", "sparse", "two values", "plateau", "huge"}) {
    for (const double tolerance : {1.0, 0.3, 0.03, 1e-3, kLeastTolerance}) {
      SCOPED_TRACE(std::string(field) + " " + std::to_string(tolerance));
      VoxelGrid g = make_bricks(2, 6, fields().at(field));
      float largest = 0;
      for (const Brick& b : g.bricks) {
        largest = std::max(largest, *std::max_element(b.values, b.values + kBrickSamples));
      }
      const double allowed = tolerance * double(largest);
      const QuantisedGrid q = quantise(g, {Precision::fpn, tolerance});
      EXPECT_LE(q.error.absolute, allowed);
      compare(g, decode(q), [&](const float* v, const float*, std::size_t b) {
        QuantisedGrid::Scale s = q.scales[b];
        if (s.bits == 1) return;
        s.bits = std::uint8_t(s.bits / 2);
        if (s.bits == 1 && s.zero) s.lo = s.hi = s.lo + (s.hi - s.lo) / 2;
        double narrower = 0;
        for (int i = 0; i < kBrickSamples; ++i) {
          narrower = std::max(narrower, double(least_error(s, v[i])));
        }
        EXPECT_GT(narrower, allowed * (1 - 1e-6)) << int(q.scales[b].bits);
      });
    }
  }
  EXPECT_EQ(quantise(make_bricks(1, 0, fields().at("plateau")), {Precision::fpn}).codes.size(),
            64u);
  EXPECT_EQ(quantise(make_bricks(1, 0, fields().at("two values")), {Precision::fpn}).error.absolute,
            0);
}

TEST(Quantise, KeepsTheToleranceOnSubnormalClouds) {
  const VoxelGrid g = make_bricks(3, 7, fields().at("subnormal"));
  EXPECT_EQ(quantise(g, {Precision::fpn, kLeastTolerance}).error.absolute, 0);
  EXPECT_EQ(quantise(g, {Precision::fp8}).error.absolute, 0);
}

/// Codes laid down by hand, of every width.
TEST(Quantise, DecodesEveryWidth) {
  for (const int bits : {1, 2, 4, 8, 16}) {
    for (const bool zero : {false, true}) {
      QuantisedGrid q;
      q.how.precision = Precision::fpn;
      q.origins = {{0, 0, 0}, {8, 0, 0}};
      const int n = (1 << bits) - (zero ? 2 : 1);
      const QuantisedGrid::Scale s{2, float(2 + n), std::uint8_t(bits), zero};
      q.scales = {{1, 1, 1, false}, s};
      q.codes.resize(code_bytes(1), 0);
      for (int byte = 0; byte < int(code_bytes(bits)); ++byte) {
        q.codes.push_back(std::uint8_t(37 * byte + 11));
      }
      const VoxelGrid g = decode(q);
      for (int i = 0; i < kBrickSamples; ++i) {
        int code = 0;
        for (int bit = 0; bit < bits; ++bit) {
          const int at = i * bits + bit;
          code |= (q.codes[code_bytes(1) + std::size_t(at / 8)] >> at % 8 & 1) << bit;
        }
        const int expected = zero ? (code == 0 ? 0 : 1 + code) : 2 + code;
        ASSERT_EQ(g.bricks[1].values[i], float(expected)) << bits << " " << zero << " " << i;
        ASSERT_EQ(g.bricks[0].values[i], 1.0f);
      }
    }
  }
}

TEST(Quantise, DependsNeitherOnThreadsNorOnTheOrderOfBricks) {
  VoxelGrid g = make_bricks(200, 8, fields().at("half empty"), 0.5f);
  for (const Precision p : kCoded) {
    const QuantisedGrid q = quantise(g, {p});
    VoxelGrid turned = g;
    std::reverse(turned.bricks.begin(), turned.bricks.end());
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const QuantisedGrid other = quantise(turned, {p});
    EXPECT_EQ(q.codes, other.codes);
    EXPECT_EQ(q.scales, other.scales);
    EXPECT_EQ(q.error, other.error);
  }
}

TEST(Quantise, InPlaceIsWhatTheCodesStandFor) {
  for (const Precision p : kCoded) {
    VoxelGrid g = make_bricks(5, 9, fields().at("half empty"), 0.5f);
    g.name = "smoke";
    const QuantisedGrid q = quantise(g, {p});
    EXPECT_EQ(quantise_in_place(g, {p}), q.error);
    EXPECT_EQ(g.name, "smoke");
    EXPECT_EQ(g.tiles.size(), 1u);
    compare(decode(q), g, [](const float* a, const float* b, std::size_t) {
      EXPECT_TRUE(std::equal(a, a + kBrickSamples, b));
    });
    // The bounds of what was decoded hold: making the field checks each of them.
    const Pyramid pyramid = build_pyramid(g);
    EXPECT_NO_THROW((void)build_field(g, pyramid));
  }
  VoxelGrid g = make_bricks(5, 9, fields().at("uniform"));
  const float* before = g.bricks[0].values;
  EXPECT_EQ(quantise_in_place(g, {Precision::fp32}), QuantisationError{});
  EXPECT_EQ(g.bricks[0].values, before);
}

TEST(Quantise, EmptyGridsStayEmpty) {
  for (const Precision p : kCoded) {
    const QuantisedGrid q = quantise(make_bricks(2, 0, [](Rng&) { return 0.0f; }), {p});
    EXPECT_TRUE(q.origins.empty() && q.codes.empty());
    EXPECT_EQ(q.error, QuantisationError{});
    EXPECT_TRUE(decode(q).bricks.empty());
  }
}

TEST(Quantise, RefusesWhatItCannotDo) {
  const VoxelGrid g = make_bricks(1, 0, fields().at("uniform"));
  EXPECT_THROW((void)quantise(g, {Precision::fp32}), Error);
  for (const double tolerance : {0.0, -1.0, 1e-6, 1.1, std::nan("")}) {
    EXPECT_THROW((void)quantise(g, {Precision::fpn, tolerance}), Error) << tolerance;
  }
  EXPECT_EQ(find_named<Precision>("fpn"), Precision::fpn);
  EXPECT_EQ(find_named<Precision>("fp7"), std::nullopt);
}

}  // namespace quantise_test
}  // namespace pvol
