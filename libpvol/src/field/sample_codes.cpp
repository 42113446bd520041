#include "pvol/field/sample_codes.h"

#include <algorithm>
#include <array>

#include "field/brick_samples.h"
#include "math/parallel.h"

namespace pvol {
namespace {

constexpr int kTopCode = 255;
constexpr std::size_t kGrain = 64;  // bricks of a task

/// Steps are no smaller than the largest sample asks, so that rounding is a small part of one
/// (THEORY.md, T3.10), and far above the smallest floats.
SampleCodes::Scale scale_of(const float* samples) {
  float lo = samples[0], hi = samples[0];
  for (int i = 1; i < kFieldSamples; ++i) {
    lo = std::min(lo, samples[i]);
    hi = std::max(hi, samples[i]);
  }
  return {lo, std::max({(hi - lo) / kTopCode, hi * 0x1p-11f, 0x1p-120f})};
}

void code_brick(SampleCodes& codes, std::size_t b, const float* samples) {
  const auto [base, step] = codes.scales[b] = scale_of(samples);
  const float per_step = 1 / step;
  std::uint8_t* const out = codes.codes.data() + b * std::size_t(kFieldSamples);
  for (int i = 0; i < kFieldSamples; ++i) {
    out[i] = std::uint8_t(int((samples[i] - base) * per_step + 0.5f));  // below 256
  }
}

template <class Field>
SampleCodes build(const Field& field) {
  SampleCodes codes;
  codes.scales.resize(field.bricks());
  codes.codes.resize(field.bricks() * std::size_t(kFieldSamples) + SampleCodes::kBeyond);
  parallel_parts(0, field.bricks(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::array<float, kFieldSamples> scratch;
    for (std::size_t b = begin; b != end; ++b) {
      code_brick(codes, b, detail::samples_of(field, std::uint32_t(b), scratch.data()));
    }
  });
  return codes;
}

}  // namespace

SampleCodes build_sample_codes(const BrickField& field) { return build(field); }
SampleCodes build_sample_codes(const SharedField& field) { return build(field); }

}  // namespace pvol
