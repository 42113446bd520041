// Rays of the camera: those of samples, and a coarse grid of them for estimates.
#pragma once

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

/// Random numbers of a sample beside those of its path.
[[nodiscard]] inline Rng numbers_aside(const PathSetup& s, int x, int y, std::uint32_t sample,
                                       Aside of) {
  const std::uint64_t pixel = std::uint64_t(y) * std::uint64_t(s.options.width) + std::uint64_t(x);
  return {s.options.seed ^ std::uint64_t(of), pixel, sample};
}

/// A point of a square, which a pixel's samples cover evenly; random numbers of paths are not
/// touched.
[[nodiscard]] inline std::array<float, 2> sample_point(const PathSetup& s, int x, int y,
                                                       std::uint32_t sample, Aside of) {
  const std::uint64_t pixel = std::uint64_t(y) * std::uint64_t(s.options.width) + std::uint64_t(x);
  return point_of_square(sample, seeds_of(s.options.seed ^ std::uint64_t(of), pixel));
}

/// The time of a camera sample, in frames. Any run of 2^k samples of a pixel that starts at a
/// multiple of it has one in each 2^k-th of the shutter: digits of the sample's number in reverse,
/// shifted by a random number of the pixel. Those of the path itself are not touched.
[[nodiscard]] inline float sample_time(const PathSetup& s, int x, int y, std::uint32_t sample) {
  const std::uint32_t reversed = reverse_bits(sample);
  const auto shift = std::uint32_t(numbers_aside(s, x, y, 0, Aside::time).block().lo);
  return float(s.view.camera.shutter.at(double(reversed + shift) * 0x1p-32));
}

/// A camera sample: its random numbers, and its ray through the pixel's filter and the lens.
struct CameraSample {
  Rng rng;
  Ray ray;

  CameraSample(const PathSetup& s, int x, int y, std::uint32_t sample)
      : rng(s.options.seed, std::uint64_t(y) * std::uint64_t(s.options.width) + std::uint64_t(x),
            sample) {
    const auto [u, v] = sample_point(s, x, y, sample, Aside::pixel);
    const double at_x = x + 0.5 + double(s.view.filter(u)),
                 at_y = y + 0.5 + double(s.view.filter(v));
    if (!s.view.projection.has_lens()) {
      ray = s.view.projection.ray(at_x, at_y);
    } else {
      const auto [lens_u, lens_v] = sample_point(s, x, y, sample, Aside::lens);
      ray = s.view.projection.ray(at_x, at_y, lens_u, lens_v);
    }
    if (s.view.motion) ray = s.view.motion->at(double(sample_time(s, x, y, sample)), ray);
  }
};

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
