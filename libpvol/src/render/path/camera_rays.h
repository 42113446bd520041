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
