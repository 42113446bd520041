// What a camera path brings home.
#pragma once

#include "render/path/path_setup.h"

namespace pvol::detail {

/// The sums of one sample. Everything that adds light to it is in gather_light.h.
struct PathResult {
  Rgb radiance{0.0f};
  float alpha = 0;  ///< estimate of 1 - transmittance

  explicit PathResult(const PathSetup&) {}
  void reset() { radiance = Rgb(0.0f), alpha = 0; }
};

/// The layers that a film of these paths has.
[[nodiscard]] inline std::vector<Layer> make_layers(const PathSetup&) { return {}; }

/// Adds a sample to the film.
inline void add_sample(const PathResult& r, std::size_t pixel, Film& film) {
  PixelSums& p = film.pixels[pixel];
  const Vec3d v(r.radiance);
  p.sum += v;
  p.sum_squares += v * v;
  p.alpha += double(r.alpha);
  ++p.samples;
}

}  // namespace pvol::detail
