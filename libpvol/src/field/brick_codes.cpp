#include "field/brick_codes.h"

#include <algorithm>

#include "density/sample_range.h"

namespace pvol::detail {
namespace {

constexpr int kTopSampleCode = 255;

/// Codes of samples that are all above 0: the nearest.
SampleCodes::Scale code_positive(const float* samples, float lo, float hi, std::uint8_t* codes) {
  // Steps are no smaller than the largest sample asks, so that rounding is a small part of one
  // (THEORY.md, T3.10), and far above the smallest floats.
  const float step = std::max({(hi - lo) / kTopSampleCode, hi * 0x1p-11f, 0x1p-120f});
  const float per_step = 1 / step;
  for (int i = 0; i < kFieldSamples; ++i) {
    codes[i] = std::uint8_t(int((samples[i] - lo) * per_step + 0.5f));  // below 256
  }
  return {lo, step};
}

/// Codes of samples of which some are 0: for the others the next above, counted in steps from 0,
/// and the middle of the step below it is what a code stands for.
SampleCodes::Scale code_from_zero(const float* samples, float hi, std::uint8_t* codes) {
  // Wider by what rounding could lift the largest sample above code 255.
  const float step = std::max(hi / kTopSampleCode * (1 + 0x1p-20f), 0x1p-120f);
  const float per_step = 1 / step;
  for (int i = 0; i < kFieldSamples; ++i) {
    const float steps = samples[i] * per_step;  // 0 for the smallest samples, too
    const int below = int(steps);
    codes[i] = std::uint8_t(std::max(below + int(steps > float(below)), int(samples[i] > 0)));
  }
  return {-0.5f * step, step};
}

/// The range of three codes that follow each other.
CodeRange join(const std::uint8_t* lo, const std::uint8_t* hi) {
  return {std::min({lo[0], lo[1], lo[2]}), std::max({hi[0], hi[1], hi[2]})};
}

}  // namespace

SampleCodes::Scale code_samples(const float* samples, std::uint8_t* codes) {
  const SampleRange range(samples, kFieldSamples);
  return range.lo() > 0 ? code_positive(samples, range.lo(), range.hi(), codes)
                        : code_from_zero(samples, range.hi(), codes);
}

void find_code_ranges(const std::uint8_t* codes, std::array<CodeRange, 64>& ranges) {
  // Axis by axis: planes, then rows, then samples.
  constexpr std::size_t kParts = 4, kRow = kFieldEdge, kPlane = kRow * kRow;
  std::array<std::uint8_t, kParts * kPlane> lo, hi;
  for (std::size_t i = 0; i < kParts; ++i) {
    const std::uint8_t* const plane = codes + 2 * i * kPlane;
    for (std::size_t k = 0; k < kPlane; ++k) {
      const std::uint8_t a = plane[k], b = plane[k + kPlane], c = plane[k + 2 * kPlane];
      lo[i * kPlane + k] = std::min(std::min(a, b), c);
      hi[i * kPlane + k] = std::max(std::max(a, b), c);
    }
  }
  for (std::size_t i = 0; i < kParts; ++i) {
    for (std::size_t j = 0; j < kParts; ++j) {
      const std::size_t first = i * kPlane + 2 * j * kRow;
      std::array<std::uint8_t, kRow> low, high;
      for (std::size_t k = 0; k < kRow; ++k) {
        const std::size_t at = first + k;
        low[k] = std::min({lo[at], lo[at + kRow], lo[at + 2 * kRow]});
        high[k] = std::max({hi[at], hi[at + kRow], hi[at + 2 * kRow]});
      }
      for (std::size_t k = 0; k < kParts; ++k) {
        ranges[(i * kParts + j) * kParts + k] = join(&low[2 * k], &high[2 * k]);
      }
    }
  }
}

CodeRange find_code_range(const std::uint8_t* codes) {
  std::uint8_t lo = codes[0], hi = codes[0];
  for (int i = 1; i < kFieldSamples; ++i) {
    lo = std::min(lo, codes[i]);
    hi = std::max(hi, codes[i]);
  }
  return {lo, hi};
}

DensityRange reach_of_codes(SampleCodes::Scale scale, CodeRange range) {
  if (scale.base < 0 && range.hi == 0) return {0, 0};
  // Look-ups among codes leave their hull by 3 ulp of 255 at most.
  constexpr float kSlack = kCodeSlack + 0x1p-12f;
  return {std::max(0.0f, scale.base + (float(range.lo) - kSlack) * scale.step),
          scale.base + (float(range.hi) + kSlack) * scale.step};
}

}  // namespace pvol::detail
