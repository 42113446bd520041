// Rays of the camera: those of samples, and a coarse grid of them for estimates.
#pragma once

#include "pvol/math/rng.h"
#include "pvol/render/options.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// A camera sample: its random numbers, from which two are drawn for the place in the pixel.
struct CameraSample {
  Rng rng;
  Ray ray;

  CameraSample(const PathSetup& s, int x, int y, std::uint32_t sample)
      : rng(s.options.seed, std::uint64_t(y) * std::uint64_t(s.options.width) + std::uint64_t(x),
            sample) {
    const auto [jitter_x, jitter_y] = rng.uniform2();
    ray = {s.projection.origin, s.projection.direction(x + double(jitter_x), y + double(jitter_y))};
  }
};

/// The time of a camera sample, in frames. Any run of 2^k samples of a pixel that starts at a
/// multiple of it has one in each 2^k-th of the shutter: digits of the sample's number in reverse,
/// shifted by a random number of the pixel. Those of the path itself are not touched.
[[nodiscard]] inline float sample_time(const PathSetup& s, int x, int y, std::uint32_t sample) {
  constexpr std::uint64_t kOfTimes = 0x7368757474657273;  // a key besides that of paths
  const std::uint64_t pixel = std::uint64_t(y) * std::uint64_t(s.options.width) + std::uint64_t(x);
  std::uint32_t reversed = sample;
  reversed = (reversed >> 16) | (reversed << 16);
  reversed = (reversed & 0x00ff00ffu) << 8 | (reversed >> 8 & 0x00ff00ffu);
  reversed = (reversed & 0x0f0f0f0fu) << 4 | (reversed >> 4 & 0x0f0f0f0fu);
  reversed = (reversed & 0x33333333u) << 2 | (reversed >> 2 & 0x33333333u);
  reversed = (reversed & 0x55555555u) << 1 | (reversed >> 1 & 0x55555555u);
  const auto shift = std::uint32_t(Rng(s.options.seed ^ kOfTimes, pixel, 0).block().lo);
  return float(s.camera.shutter.at(double(reversed + shift) * 0x1p-32));
}

/// visit(ray, i) for count^2 rays, evenly over the part of the image that is rendered.
template <class Visit>
void visit_coarse_rays(const Projection& projection, const RenderOptions& o, int count,
                       const Visit& visit) {
  const ImagePart part = image_part(o);
  for (int i = 0; i < count * count; ++i) {
    const int row = i / count;
    const double x = part.x + part.width * (i % count + 0.5) / count;
    const double y = part.y + part.height * (row + 0.5) / count;
    visit(Ray{projection.origin, projection.direction(x, y)}, i);
  }
}

}  // namespace pvol::detail
