// The layers of a film that a render fills, and samples on their way into it.
#pragma once

#include <array>

#include "render/path/path_result.h"

namespace pvol::detail {

/// An empty film of the part that is rendered, without layers and sums.
[[nodiscard]] Film make_film(const RenderOptions& options);

/// Samples of a part of the film; pixels are counted from the film's own corner.
[[nodiscard]] std::uint64_t count_samples(const Film& film, const ImagePart& part);

/// The layers that a film of these paths has, for so many pixels.
[[nodiscard]] std::vector<Layer> make_layers(const PathSetup& setup, std::size_t pixels);

/// The bins of depth of such a film: none where nobody asks for them, else between the front and
/// the back of what the volumes' boxes have before the camera while the shutter is open.
[[nodiscard]] DeepFilm make_deep(const PathSetup& setup, std::size_t pixels);

/// An empty film of these paths, with its layers, bins, counts and exact sums.
[[nodiscard]] Film make_film(const PathSetup& setup);

/// Makes room for the counts of a film's pixels, if there is none.
inline void keep_counts(Film& film) { film.counts.resize(film.pixels.size()); }

/// Adds a sample that met something to the film's bins, at its depth along the axis of the camera
/// as that stands at the sample's time.
void add_to_deep(const PathSetup& setup, const PathResult& r, std::size_t pixel, Film& film);

/// Adds a sample to the sums of a pixel's layers, which were made for its setup, and its least
/// values to the film.
void add_to_layers(const PathSetup& setup, const PathResult& r, std::size_t pixel, ExactSums& sums,
                   Film& film);

/// Samples of a pixel on their way into its exact sums, a row for each channel.
struct PixelRows {
  static constexpr std::size_t kMost = 32;
  using Row = std::array<double, kMost>;

  std::size_t n = 0, n_of_group = 0;
  std::array<Row, 3> light, squares;
  Row alpha, group;  // of which only its samples have a place in their row

  void add(const PathResult& r, bool in_group) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = double(r.radiance[int(c)]);
      light[c][n] = v, squares[c][n] = v * v;
    }
    alpha[n++] = double(r.alpha);
    if (in_group) group[n_of_group++] = luminance(Vec3d(r.radiance));
  }
};

/// Adds them to the sums of a pixel, and leaves none.
inline void add_rows(PixelRows& rows, ExactSums& to) {
  const auto of = [](const std::array<PixelRows::Row, 3>& all) {
    return std::array{all[0].data(), all[1].data(), all[2].data()};
  };
  to.light.add(of(rows.light), rows.n);
  to.squares.add(of(rows.squares), rows.n);
  to.alpha.add({rows.alpha.data()}, rows.n);
  to.group.add({rows.group.data()}, rows.n_of_group);
  rows.n = rows.n_of_group = 0;
}

/// Adds what a film has beside the sums of its pixels: layers and bins of depth.
inline void add_aside(const PathSetup& setup, const PathResult& r, std::size_t pixel,
                      ExactSums& sums, Film& film) {
  if (!film.layers.empty()) add_to_layers(setup, r, pixel, sums, film);
  if (!film.deep.pixels.empty() && (r.first_weight != 0 || r.first_material))
    add_to_deep(setup, r, pixel, film);
}

}  // namespace pvol::detail
