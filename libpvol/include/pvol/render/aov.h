// What a film keeps beside colour and alpha where it is asked for: its further layers, which others
// call AOVs. Each has one row, from which the option, channels in files and manuals follow.
#pragma once

#include <array>

#include "pvol/math/names.h"

namespace pvol {

enum class Aov {
  transmittance,
  variance,
  samples,
  lights,
  scattering,
  halves,
  transmittance_rgb,
  depth,
  nearest,
  position,
  normal,
  albedo,
  velocity,
  objects,
  lookups,
  bounds_tests,
  segments,
  collisions,
};

struct AovRow {
  Aov aov;
  const char* name;      ///< on command lines and in scenes; of layers in files, but for `lights`
  const char* meaning;   ///< of a pixel's value
  const char* units;     ///< "" for a pure number
  const char* channels;  ///< a letter for each component, after the layer's name and a dot
  const char* sums;      ///< how it accumulates over a pixel's samples
  bool colour = false;  ///< whether it is light: a picture, which files may round as they do colour
  bool counted = false;  ///< whether rendering it takes counts, which cost a few per cent of time
};

inline constexpr std::array kAovs = std::to_array<AovRow>({
    {Aov::transmittance, "transmittance", "share of the background that shows through", "", "Y",
     "mean over the samples; 1 - alpha of the film, even where a background is visible"},
    {Aov::variance, "variance", "variance of the pixel's mean colour, by channel",
     "squares of radiance", "RGB",
     "from sums of samples and of their squares, as if independent; 0 for a single sample"},
    {Aov::samples, "samples", "camera samples", "", "Y", "their number"},
    {Aov::lights, "lights",
     "light of the sky, of each sun or point light and of emission in separate layers, which sum "
     "up to the picture: sky, sun_1, point_1, emission",
     "radiance", "RGB", "means over the samples", true},
    {Aov::scattering, "scattering",
     "light by number of scatterings in separate layers, which sum up to the picture: unscattered, "
     "single, multiple",
     "radiance", "RGB", "means over the samples", true},
    {Aov::halves, "halves", "pictures of the odd and the even samples, in layers: half_1, half_2",
     "radiance", "RGB",
     "each the mean over half of the samples; independent, so the picture's noise is another one",
     true},
    {Aov::transmittance_rgb, "transmittance_rgb",
     "share of the background that shows through, by channel: where light that reaches a shadow "
     "has a colour of its own, and where the extinction differs by channel",
     "", "RGB",
     "mean over the samples; without a visible background, the picture plus this times a "
     "photograph is the photograph with the clouds in it",
     true},
    {Aov::depth, "depth",
     "depth of first collisions along the camera's axis; 1e10 where there is none", "world units",
     "Z", "mean over the samples that collide"},
    {Aov::nearest, "nearest", "depth of the nearest first collision; 1e10 where there is none",
     "world units", "Z", "minimum over the samples"},
    {Aov::position, "position", "position of first collisions in the world", "world units", "XYZ",
     "mean over the samples that collide"},
    {Aov::normal, "normal",
     "direction of steepest descent of the extinction at first collisions; shorter than 1 where "
     "directions differ",
     "", "XYZ", "mean over the samples that collide"},
    {Aov::albedo, "albedo", "albedo at first collisions", "", "RGB",
     "mean over the samples that collide", true},
    {Aov::velocity, "velocity",
     "how far what first collisions hit moves in a frame, by its velocities and as a whole",
     "world units a frame", "XYZ", "mean over the samples that collide"},
    {Aov::objects, "objects",
     "share of the pixel that shows a volume, at one of its places, or a surface, in a layer for "
     "each: object.volume_1, object.volume_2.3, object.plane_1; in files also as Cryptomatte",
     "", "Y", "mean over the samples of what first collisions hit"},
    {Aov::lookups, "lookups", "look-ups of the density", "a sample", "Y", "mean over the samples",
     false, true},
    {Aov::bounds_tests, "bounds_tests", "tentative collisions compared with bounds", "a sample",
     "Y", "mean over the samples", false, true},
    {Aov::segments, "segments", "segments walked between bounds", "a sample", "Y",
     "mean over the samples", false, true},
    {Aov::collisions, "collisions", "real collisions of camera paths", "a sample", "Y",
     "mean over the samples", false, true},
});

/// Layers of a film that have other names than their row: of `scattering`, of `halves`, and those
/// that the filter adds (denoise.h).
inline constexpr std::array<const char*, 3> kOrderLayers = {"unscattered", "single", "multiple"};
inline constexpr std::array<const char*, 2> kHalfLayers = {"half_1", "half_2"};
inline constexpr std::array<const char*, 2> kNoisyLayers = {"noisy", "noisy_variance"};

[[nodiscard]] constexpr auto names(Aov) {
  std::array<Named<Aov>, kAovs.size()> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = {kAovs[i].aov, kAovs[i].name};
  return all;
}

[[nodiscard]] constexpr const AovRow& row(Aov aov) { return kAovs[std::size_t(aov)]; }

using AovSet = SetOf<Aov>;

/// Whether they tell of first collisions.
[[nodiscard]] constexpr bool of_first_collisions(AovSet aovs) {
  return aovs.has(Aov::depth) || aovs.has(Aov::nearest) || aovs.has(Aov::position) ||
         aovs.has(Aov::normal) || aovs.has(Aov::albedo) || aovs.has(Aov::velocity) ||
         aovs.has(Aov::objects);
}

/// Whether rendering them takes counts.
[[nodiscard]] constexpr bool counted(AovSet aovs) {
  for (const AovRow& r : kAovs) {
    if (r.counted && aovs.has(r.aov)) return true;
  }
  return false;
}

namespace detail {
[[nodiscard]] constexpr bool aovs_in_order() {
  for (std::size_t i = 0; i < kAovs.size(); ++i) {
    if (std::size_t(kAovs[i].aov) != i) return false;
  }
  return true;
}
}  // namespace detail
static_assert(detail::aovs_in_order(), "the rows of AOVs must be in the order of the enumeration");

}  // namespace pvol
