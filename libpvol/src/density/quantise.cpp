// Codes of samples, brick by brick (THEORY.md, T1.9).
#include "pvol/density/quantise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pvol/density/sample_count.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

constexpr int kHalfMantissa = 10, kHalfMinExponent = -24;  // of a subnormal's unit
constexpr std::uint16_t kLargestHalf = 0x7bff;
constexpr int kWidths[] = {1, 2, 4, 8, 16};

using Scale = QuantisedGrid::Scale;
using Codes = std::array<std::uint16_t, kBrickSamples>;

/// The nearest half of v / 2^exponent, which is below 2^16; never 0 for v > 0, never infinite.
std::uint16_t encode_half(float v, int exponent) {
  if (v == 0) return 0;
  const double units = std::ldexp(double(v), -exponent - kHalfMinExponent);
  const int shift = std::max(0, std::ilogb(units) - kHalfMantissa);
  // A mantissa that rounds up to 2^11 carries into the exponent, as it should.
  const double code = std::rint(std::ldexp(units, -shift)) + (shift << kHalfMantissa);
  return std::uint16_t(std::clamp(code, 1.0, double(kLargestHalf)));
}

/// The exponent that puts the largest sample into [2^15, 2^16), the top of the halves.
int half_exponent(float largest) { return largest > 0 ? std::ilogb(largest) - 15 : 0; }

/// Steps from lo to hi.
int steps(const Scale& s) { return (1 << s.bits) - (s.zero ? 2 : 1); }

double step_length(const Scale& s) {
  const int n = steps(s);
  return n > 0 ? (double(s.hi) - double(s.lo)) / n : 0;
}

/// What codes stand for, with the division done once.
class Values {
 public:
  explicit Values(const Scale& s) : lo_(double(s.lo)), step_(step_length(s)), zero_(s.zero) {}

  [[nodiscard]] float operator()(int code) const {
    if (zero_ && code-- == 0) return 0;
    return float(lo_ + code * step_);
  }

 private:
  double lo_, step_;
  bool zero_;
};

/// The scale of a brick's positive samples, of which there is one at least.
Scale make_scale(const float* values, int bits) {
  Scale s{std::numeric_limits<float>::max(), 0, std::uint8_t(bits), false};
  for (int i = 0; i < kBrickSamples; ++i) {
    s.zero |= values[i] == 0;
    if (values[i] > 0) s.lo = std::min(s.lo, values[i]);
    s.hi = std::max(s.hi, values[i]);
  }
  // One code for all positive samples errs least in their middle.
  if (steps(s) == 0) s.lo = s.hi = s.lo + (s.hi - s.lo) / 2;
  return s;
}

/// The nearest code; of a positive sample that of a positive value.
int encode(const Scale& s, double step, float v) {
  if (v == 0) return 0;
  const double at = step > 0 ? (double(v) - double(s.lo)) / step : 0;
  return std::clamp(int(std::lround(at)), 0, steps(s)) + (s.zero ? 1 : 0);
}

Codes encode(const Scale& s, const float* values) {
  const double step = step_length(s);
  Codes codes;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes[i] = std::uint16_t(encode(s, step, values[i]));
  }
  return codes;
}

/// Sums and extremes over a brick.
struct BrickError {
  double absolute = 0, relative = 0, change = 0, mass = 0;
};

template <class Decode>
BrickError measure(const float* values, const Decode& decoded) {
  BrickError e;
  for (int i = 0; i < kBrickSamples; ++i) {
    const double v = double(values[i]), d = double(decoded(std::size_t(i))) - v;
    e.absolute = std::max(e.absolute, std::abs(d));
    if (v > 0) e.relative = std::max(e.relative, std::abs(d) / v);
    e.change += d;
    e.mass += v;
  }
  return e;
}

BrickError measure(const float* values, const Scale& s, const Codes& codes) {
  const Values value(s);
  return measure(values, [&](std::size_t i) { return value(codes[i]); });
}

void pack(const Codes& codes, int bits, std::uint8_t* to) {
  std::fill_n(to, code_bytes(bits), std::uint8_t(0));
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const std::size_t bit = i * std::size_t(bits);
    to[bit / 8] = std::uint8_t(to[bit / 8] | codes[i] << bit % 8);
    if (bits == 16) to[bit / 8 + 1] = std::uint8_t(codes[i] >> 8);
  }
}

int unpack(const std::uint8_t* from, int bits, std::size_t i) {
  const std::size_t bit = i * std::size_t(bits);
  if (bits == 16) return from[bit / 8] | from[bit / 8 + 1] << 8;
  return from[bit / 8] >> bit % 8 & ((1 << bits) - 1);
}

/// Writes the codes of a brick and tells how far they are off.
BrickError encode_halves(const float* values, int exponent, std::uint8_t* to) {
  Codes codes;
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = encode_half(values[i], exponent);
  pack(codes, 16, to);
  return measure(values, [&](std::size_t i) { return decode_half(codes[i], exponent); });
}
BrickError encode_steps(const float* values, const Scale& s, std::uint8_t* to) {
  const Codes codes = encode(s, values);
  pack(codes, s.bits, to);
  return measure(values, s, codes);
}

/// The narrowest scale whose error is within the tolerance; the widest one's always is.
Scale narrowest_scale(const float* values, double tolerance) {
  for (const int bits : kWidths) {
    const Scale s = make_scale(values, bits);
    if (bits == kWidths[4] || measure(values, s, encode(s, values)).absolute <= tolerance) return s;
  }
  return {};  // not reached
}

std::vector<std::size_t> brick_offsets(const QuantisedGrid& q) {
  std::vector<std::size_t> at(q.origins.size());
  std::size_t end = 0;
  for (std::size_t b = 0; b < at.size(); ++b) {
    at[b] = end;
    end += code_bytes(q.scales.empty() ? 16 : q.scales[b].bits);
  }
  return at;
}

QuantisationError total(const std::vector<BrickError>& bricks, const std::vector<Tile>& tiles) {
  QuantisationError e;
  double change = 0, mass = 0;
  for (const BrickError& b : bricks) {
    e.absolute = std::max(e.absolute, b.absolute);
    e.relative = std::max(e.relative, b.relative);
    change += b.change;
    mass += b.mass;
  }
  for (const Tile& t : tiles) mass += double(t.value) * std::pow(double(t.edge), 3);
  if (mass > 0) e.mass = change / mass;
  return e;
}

template <class Value>
void fill(float* to, const Value& value) {
  for (std::size_t i = 0; i < std::size_t(kBrickSamples); ++i) to[i] = value(i);
}

}  // namespace

float decode_half(std::uint16_t code, int exponent) {
  const int e = code >> kHalfMantissa, m = code & ((1 << kHalfMantissa) - 1);
  const int shift = std::max(0, e - 1) + kHalfMinExponent + exponent;
  return float(std::ldexp(double(e > 0 ? m + (1 << kHalfMantissa) : m), shift));
}

QuantisedGrid quantise(const VoxelGrid& grid, const Quantisation& how) {
  if (how.precision == Precision::fp32) {
    throw Error("found fp32, which is not quantised; expected fp16, fp8 or fpn");
  }
  if (!(how.tolerance >= kLeastTolerance && how.tolerance <= kLargestTolerance)) {
    throw Error("the tolerance is " + std::to_string(how.tolerance) +
                " of the largest density; expected " + expected(number(kToleranceRange)));
  }
  const VoxelGrid g = occupied(grid);
  const float largest = count_samples(g).largest;
  QuantisedGrid q;
  q.name = g.name;
  q.index_to_world = g.index_to_world;
  q.how = how;
  q.tiles = g.tiles;
  for (const Brick& b : g.bricks) q.origins.push_back(b.origin);
  const std::size_t count = g.bricks.size();
  const bool half = how.precision == Precision::fp16;
  if (half) {
    q.exponent = half_exponent(largest);
  } else {
    q.scales.resize(count);
    parallel_for(0, count, [&](std::size_t b) {
      q.scales[b] = how.precision == Precision::fp8
                        ? make_scale(g.bricks[b].values, 8)
                        : narrowest_scale(g.bricks[b].values, how.tolerance * double(largest));
    });
  }
  const std::vector<std::size_t> at = brick_offsets(q);
  if (count > 0) q.codes.resize(at.back() + code_bytes(half ? 16 : q.scales.back().bits));
  std::vector<BrickError> errors(count);
  parallel_for(0, count, [&](std::size_t b) {
    errors[b] = half ? encode_halves(g.bricks[b].values, q.exponent, &q.codes[at[b]])
                     : encode_steps(g.bricks[b].values, q.scales[b], &q.codes[at[b]]);
  });
  q.error = total(errors, q.tiles);
  return q;
}

VoxelGrid decode(const QuantisedGrid& q) {
  VoxelGrid g;
  g.name = q.name;
  g.index_to_world = q.index_to_world;
  g.tiles = q.tiles;
  const std::size_t count = q.origins.size();
  const auto values = std::make_shared_for_overwrite<float[]>(count * kBrickSamples);
  const std::vector<std::size_t> at = brick_offsets(q);
  parallel_for(0, count, [&](std::size_t b) {
    float* to = values.get() + b * kBrickSamples;
    const std::uint8_t* codes = &q.codes[at[b]];
    if (q.scales.empty()) {
      fill(to, [&](std::size_t i) {
        return decode_half(std::uint16_t(unpack(codes, 16, i)), q.exponent);
      });
    } else {
      const Values value(q.scales[b]);
      fill(to, [&](std::size_t i) { return value(unpack(codes, q.scales[b].bits, i)); });
    }
  });
  for (std::size_t b = 0; b < count; ++b) {
    g.bricks.push_back({q.origins[b], values.get() + b * kBrickSamples});
  }
  g.owner = values;
  return g;
}

QuantisationError quantise_in_place(VoxelGrid& grid, const Quantisation& how) {
  if (how.precision == Precision::fp32) return {};
  const QuantisedGrid q = quantise(grid, how);
  grid = decode(q);
  return q.error;
}

}  // namespace pvol
