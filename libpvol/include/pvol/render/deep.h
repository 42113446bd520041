// Pictures with depth: what the pixels of a camera see, by its distance along the camera's axis,
// or from a latlong camera (THEORY.md, T5.9).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol {

/// The samples of a pixel whose paths first collided within one interval of depth.
struct DeepBin {
  Vec3d sum;  ///< of their radiance
  std::uint32_t count = 0;
  std::uint32_t number = 0;  ///< of the interval, from the front
};

/// The samples of a pixel that first met a surface at about one depth.
struct DeepSurface {
  Vec3d sum;         ///< of their radiance
  double alpha = 0;  ///< sum; a sample that shows a shadow alone covers a part, or less than none
  double depth = 0;  ///< sum of their depths
  std::uint32_t count = 0;
  std::int64_t number = 0;  ///< of the interval, in order of depth; its ends are 0.1 % apart
};

/// What a film's samples met first, by depth, which is in world units along the camera's axis,
/// or from the camera where it sees all directions (latlong): collisions in bins, and surfaces
/// where they are. A bin that nothing is in takes no memory; one that something is in,
/// sizeof(DeepBin).
struct DeepFilm {
  double front = 0, back = 0;  ///< where the bins, of equal length, begin and end
  int bins = 0;
  /// Of each pixel of the film, by number; empty where they were not asked for.
  std::vector<std::vector<DeepBin>> pixels{};
  /// Likewise; at most `bins` of a pixel, which take in what is nearest when they are full.
  std::vector<std::vector<DeepSurface>> surfaces{};

  /// Depth where bin `number` begins, and the one before it ends.
  [[nodiscard]] double edge(std::uint32_t number) const {
    const double share = double(number) / bins;
    return front * (1 - share) + back * share;
  }

  /// Adds a sample of this radiance that collided at this depth; one before the first bin or behind
  /// the last, as rounding may have it, belongs to that.
  void add(std::size_t pixel, double depth, Vec3d radiance);

  /// Adds a sample that met a surface at this depth, above 0.
  void add_surface(std::size_t pixel, double depth, Vec3d radiance, double alpha);
};

/// A part of what a pixel sees, in the sense of OpenEXR's deep pixels: between the depths z and
/// z_back an even medium that covers and emits, or where they are equal a thin veil.
struct DeepSample {
  double z = 0, z_back = 0;  ///< z <= z_back
  Vec3d colour;              ///< that it adds before black, where nothing is in front of it
  double alpha = 0;          ///< in [0, 1]: the share that it covers of what is behind
};

/// What a pixel of `samples` camera samples sees: from front to back, disjoint. Surfaces are thin
/// samples at the mean of their depths; the medium of their bin lies before them where nothing lies
/// behind, else it is divided there. `error`, 0 or more, is a share of the pixel's alpha, and of
/// its colour in each channel: neighbouring bins are one sample where alpha and colour of all that
/// is before a depth, as functions of it, change by no more than that anywhere. All together give
/// the film's alpha, but for shadow catchers below 0, and its colour without background, but
/// for rounding. A sample that covers all the rest (alpha 1) is thin, in the middle of its bin.
[[nodiscard]] std::vector<DeepSample> deep_samples(const DeepFilm& film, std::size_t pixel,
                                                   std::uint32_t samples, double error);

/// Colour and alpha of parts seen together.
struct DeepValue {
  Vec3d colour;
  double alpha = 0;
};

/// What of such samples lies before a depth; a thin one at it does not.
[[nodiscard]] DeepValue seen_before(std::span<const DeepSample> samples, double depth);

/// All of them.
[[nodiscard]] DeepValue flatten(std::span<const DeepSample> samples);

/// The most memory that the bins of a film can take, in bytes, with surfaces or without.
[[nodiscard]] double most_deep_bytes(double pixels, int bins, double samples, bool surfaces);

/// More than that is refused.
inline constexpr double kMostDeepBytes = 0x1p33;

/// Adds those of a film of the same size and bins. Throws Error for others.
void add_samples(DeepFilm& to, const DeepFilm& from);

}  // namespace pvol
