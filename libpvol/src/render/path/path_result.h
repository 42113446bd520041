// What a camera path brings home.
#pragma once

#include <string>

#include "pvol/error.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// The sums of one sample. Everything that adds light to it is in gather_light.h. Layers are those
/// of each light in their order, then of the sky, which has all that is constant, and of emission;
/// none where nobody asks for them.
struct PathResult {
  Rgb radiance{0.0f};
  float alpha = 0;  ///< estimate of 1 - transmittance
  std::vector<Rgb> layers;

  explicit PathResult(const PathSetup& s)
      : layers(s.options.aovs.has(Aov::lights) ? s.lights.size() + 2 : 0) {}
  void reset() {
    radiance = Rgb(0.0f), alpha = 0;
    for (Rgb& layer : layers) layer = Rgb(0.0f);
  }

  [[nodiscard]] bool in_layers() const { return !layers.empty(); }
  [[nodiscard]] Rgb& sky() { return layers[layers.size() - 2]; }
  [[nodiscard]] Rgb& emission() { return layers.back(); }
};

/// The layers that a film of these paths has.
[[nodiscard]] inline std::vector<Layer> make_layers(const PathSetup& s) {
  std::vector<Layer> layers;
  if (!s.options.aovs.has(Aov::lights)) return layers;
  for (const std::string& name : s.light_names) layers.push_back({name, {}});
  layers.push_back({"sky", {}});
  layers.push_back({"emission", {}});
  return layers;
}

/// Throws Error for a sample of pixel (x, y) that is more than a float holds.
inline void require_finite(const PathResult& r, int x, int y) {
  if (is_finite(r.radiance)) return;
  throw Error("pixel (" + std::to_string(x) + ", " + std::to_string(y) +
              ") became infinite: the lights are too bright for single precision");
}

/// Adds a sample to the film.
inline void add_sample(const PathResult& r, std::size_t pixel, Film& film) {
  PixelSums& p = film.pixels[pixel];
  const Vec3d v(r.radiance);
  p.sum += v;
  p.sum_squares += v * v;
  p.alpha += double(r.alpha);
  ++p.samples;
  for (std::size_t k = 0; k < r.layers.size(); ++k)
    film.layers[k].sums[pixel] += Vec3d(r.layers[k]);
}

}  // namespace pvol::detail
