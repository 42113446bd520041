// What the filter wants of a film, as planes.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "pvol/render/film.h"
#include "render/denoise/fireflies.h"
#include "render/denoise/patch_weights.h"

namespace pvol::detail {

/// The two halves of a film's samples, in units of `scale`.
struct Halves {
  double scale = 1;             ///< radiance that is 1 in the planes: the film's mean
  std::array<Guide, 2> colour;  ///< without fireflies; variances of the halves' means, smoothed
  Fireflies fireflies;          ///< whose light is spread over the halves
  Plane filtered;               ///< 1 for pixels that are to be filtered, else 0
  bool any = false;             ///< whether there are such pixels
};
[[nodiscard]] Halves make_halves(const Film& film, int margin);

/// What features tell of: layers, and alpha.
enum class FeatureKind { alpha, depth, normal, albedo, velocity };

/// What a feature's plane is, so that those of another frame can be put in its units.
struct FeatureScale {
  FeatureKind kind = FeatureKind::alpha;
  int component = 0;
  double centre = 0, spread = 1;       ///< the plane has (value - centre) / spread
  std::optional<std::size_t> plane{};  ///< none: the value is `centre` everywhere
};

/// Features of about the scale 1, filtered by themselves: place in the picture, alpha, and what
/// first collisions tell. Those that are the same everywhere have no plane.
struct Features {
  Planes planes;                     ///< the first two are the place
  std::vector<FeatureScale> scales;  ///< of the others
};

/// Heeds `stop`.
[[nodiscard]] Features make_features(const Film& film, int margin,
                                     const std::function<bool()>& stop);

/// Velocities of first collisions, filtered like features, if the film has them. Heeds `stop`.
[[nodiscard]] std::optional<Features> make_velocity(const Film& film, int margin,
                                                    const std::function<bool()>& stop);

/// Throws Error once `stop`, if there is one, is true.
void heed(const std::function<bool()>& stop);

/// Throws Error for films that lack a layer, samples or finite pixels.
void check_film(const Film& film);

}  // namespace pvol::detail
