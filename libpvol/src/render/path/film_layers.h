// The layers of a film that a render fills, and samples on their way into it.
#pragma once

#include "render/path/path_result.h"

namespace pvol::detail {

/// An empty film of the part that is rendered, without layers and sums.
[[nodiscard]] Film make_film(const RenderOptions& options);

/// Samples of a part of the film; pixels are counted from the film's own corner.
[[nodiscard]] std::uint64_t count_samples(const Film& film, const ImagePart& part);

/// The layers that a film of these paths has, for so many pixels.
[[nodiscard]] std::vector<Layer> make_layers(const PathSetup& setup, std::size_t pixels);

/// The bins of depth of such a film: none where nobody asks for them, else between the front and
/// the back of what the volumes' boxes have before the camera.
[[nodiscard]] DeepFilm make_deep(const PathSetup& setup, std::size_t pixels);

/// An empty film of these paths, with its layers, bins and sums.
[[nodiscard]] Film make_film(const PathSetup& setup);

/// Adds a sample that met something to those bins.
void add_to_deep(const PathSetup& setup, const PathResult& r, std::size_t pixel, DeepFilm& film);

/// Adds a sample to layers that were made for its setup.
void add_to_layers(const PathSetup& setup, const PathResult& r, std::size_t pixel, Film& film);

/// Adds a sample to the film's exact sums; `flush` brings the pixel's others up to date.
inline void add_sample(const PathSetup& setup, const PathResult& r, std::size_t pixel, Film& film) {
  if (!film.layers.empty()) add_to_layers(setup, r, pixel, film);
  if (!film.deep.pixels.empty() && (r.first_weight != 0 || r.first_material))
    add_to_deep(setup, r, pixel, film.deep);
  ExactPixel& p = film.sums.pixels[pixel];
  const Vec3d v(r.radiance);
  add(p.light, v);
  add(p.squares, v * v);
  add(p.alpha, double(r.alpha));
  ++film.pixels[pixel].samples;
}

}  // namespace pvol::detail
