// Rays of the camera: those of samples, and a coarse grid of them for estimates.
#pragma once

#include <bit>

#include "math/philox.h"
#include "pvol/render/options.h"
#include "render/path/path_setup.h"
#include "render/path/sequences.h"

namespace pvol::detail {

/// What a camera sample has besides its path: each in a sequence of its own.
enum class Aside : std::uint64_t {
  pixel = 0x706978656c,
  lens = 0x6c656e73,
  time = 0x7368757474657273,
  lights = 0x6c6967687473,
};

/// A sample of a pixel of the image.
struct PixelSample {
  int x, y;  ///< of the pixel
  std::uint32_t number;
};

/// The number of its pixel.
[[nodiscard]] inline std::uint64_t pixel_of(const PathSetup& s, const PixelSample& sample) {
  return std::uint64_t(sample.y) * std::uint64_t(s.options.width) + std::uint64_t(sample.x);
}

/// Random numbers of its path.
[[nodiscard]] inline Rng numbers_of(const PathSetup& s, const PixelSample& sample) {
  return {s.options.seed, pixel_of(s, sample), sample.number};
}
/// Random numbers beside those.
[[nodiscard]] inline Rng numbers_aside(const PathSetup& s, const PixelSample& sample, Aside of) {
  return {s.options.seed ^ std::uint64_t(of), pixel_of(s, sample), sample.number};
}

/// Its number in the sequences of its pixel. All samples are of the same ones, or each half is of
/// its own where one must tell nothing of the other (THEORY.md, T5.15).
[[nodiscard]] inline std::uint32_t number_in_sequence(const PathSetup& s,
                                                      const PixelSample& sample) {
  return s.halves ? sample.number / 2 : sample.number;
}

/// Whether the sample of a number is of the group that the film also sums by itself
/// (PixelSums::group). The groups are the halves above, or made of runs of samples in turn, each as
/// long as all before it: whatever their number, most of either group are a run, which covers the
/// pixel evenly.
[[nodiscard]] inline bool is_in_group(const PathSetup& s, std::uint32_t number) {
  constexpr std::uint32_t kFirst = 7;  // the first run is 0 to 7
  return s.halves ? number % 2 == 0 : std::bit_width(number | kFirst) % 2 == 0;
}

/// Points of a square, which the samples of a sequence cover evenly; random numbers of paths are
/// not touched.
[[nodiscard]] inline std::array<std::uint32_t, 3> seeds_of_points(const PathSetup& s,
                                                                  const PixelSample& sample,
                                                                  Aside of) {
  const std::uint64_t half = s.halves ? sample.number % 2 : 0;
  return seeds_of(s.options.seed ^ std::uint64_t(of) ^ half << 63, pixel_of(s, sample));
}
[[nodiscard]] inline std::array<float, 2> sample_point(const PathSetup& s,
                                                       const PixelSample& sample, Aside of) {
  return point_of_square(number_in_sequence(s, sample), seeds_of_points(s, sample, of));
}

/// The time of a camera sample, in frames. Any run of 2^k samples of a sequence that starts at a
/// multiple of it has one in each 2^k-th of the shutter: digits of the sample's number in reverse,
/// shifted by a random number of the sequence. Those of the path itself are not touched.
[[nodiscard]] inline float sample_time(const PathSetup& s, const PixelSample& sample) {
  const std::uint32_t reversed = reverse_bits(number_in_sequence(s, sample));
  const std::uint32_t shift = seeds_of_points(s, sample, Aside::time)[0];
  return float(s.view.camera.shutter.at(double(reversed + shift) * 0x1p-32));
}

/// The ray of a sample, through the pixel's filter and the lens.
[[nodiscard]] inline Ray camera_ray(const PathSetup& s, const PixelSample& sample) {
  const auto [u, v] = sample_point(s, sample, Aside::pixel);
  const double x = sample.x + 0.5 + double(s.view.filter(u));
  const double y = sample.y + 0.5 + double(s.view.filter(v));
  Ray ray;
  if (!s.view.projection.has_lens()) {
    ray = s.view.projection.ray(x, y);
  } else {
    const auto [lens_u, lens_v] = sample_point(s, sample, Aside::lens);
    ray = s.view.projection.ray(x, y, lens_u, lens_v);
  }
  return s.view.motion ? s.view.motion->at(double(sample_time(s, sample)), ray) : ray;
}

/// visit(ray, i) for count^2 rays, evenly over a part of the image.
template <class Visit>
void visit_coarse_rays(const Projection& projection, const ImagePart& part, int count,
                       const Visit& visit) {
  for (int i = 0; i < count * count; ++i) {
    const int row = i / count;
    const double x = part.x + part.width * (i % count + 0.5) / count;
    const double y = part.y + part.height * (row + 0.5) / count;
    visit(projection.ray(x, y), i);
  }
}

}  // namespace pvol::detail
