// The picture with its statistics.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol {

/// What one camera path cost, summed over paths; all zero where counting was off.
/// "Path" counts belong to the camera path's own free flights, "shadow" ones to transmittance.
struct Counts {
  std::uint64_t lookups_path = 0, lookups_shadow = 0;  ///< evaluations of the exact density
  std::uint64_t bounds_tests_path = 0, bounds_tests_shadow = 0;  ///< decisions from bounds alone
  std::uint64_t segments_path = 0, segments_shadow = 0;  ///< segments of constant bounds visited
  std::uint64_t collisions = 0, null_collisions = 0;     ///< of camera paths
  std::uint64_t shadow_rays = 0;
  std::uint64_t shell_tests = 0, shell_rejections = 0;  ///< of camera rays that meet the box

  Counts& operator+=(const Counts& c) {
    lookups_path += c.lookups_path, lookups_shadow += c.lookups_shadow;
    bounds_tests_path += c.bounds_tests_path, bounds_tests_shadow += c.bounds_tests_shadow;
    segments_path += c.segments_path, segments_shadow += c.segments_shadow;
    collisions += c.collisions, null_collisions += c.null_collisions;
    shadow_rays += c.shadow_rays;
    shell_tests += c.shell_tests, shell_rejections += c.shell_rejections;
    return *this;
  }
  friend bool operator==(const Counts&, const Counts&) = default;
};

/// Sums over the samples of one pixel, in sample order and in double.
struct PixelSums {
  Vec3d sum;          ///< of radiance
  Vec3d sum_squares;  ///< of radiance squared, by channel
  double alpha = 0;   ///< of 1 - transmittance
  std::uint32_t samples = 0;
  std::uint64_t lookups = 0, segments = 0, collisions = 0;  ///< totals; 0 where counting was off
};

/// The rendered rectangle of an image, rows from the top.
struct Film {
  int width = 0, height = 0;            ///< of the whole image
  int x = 0, y = 0;                     ///< upper left corner of the rectangle in the image
  int crop_width = 0, crop_height = 0;  ///< of the rectangle
  std::vector<PixelSums> pixels;        ///< crop_width * crop_height

  [[nodiscard]] const PixelSums& at(int px, int py) const {
    return pixels[std::size_t(py) * std::size_t(crop_width) + std::size_t(px)];
  }
};

/// Mean radiance of a pixel; 0 without samples.
[[nodiscard]] inline Vec3d mean(const PixelSums& p) {
  return p.samples ? p.sum / double(p.samples) : Vec3d{};
}

/// Unbiased estimate of the variance of that mean, by channel; 0 with fewer than two samples.
[[nodiscard]] inline Vec3d variance_of_mean(const PixelSums& p) {
  if (p.samples < 2) return {};
  const double n = p.samples;
  return max((p.sum_squares - p.sum * p.sum / n) / (n * (n - 1)), Vec3d{});
}

}  // namespace pvol
