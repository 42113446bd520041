// A filter for the noise of finished pictures. It makes them biased, and says by how much it errs.
//
// Based on: Bitterli et al. Nonlinearly Weighted First-order Regression for Denoising Monte Carlo
// Renderings. 2016; Rousselle et al. Adaptive Rendering with Non-Local Means Filtering. 2012
// (THEORY.md, T5.10, T5.21, T5.22 and T5.23).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pvol/render/aov.h"
#include "pvol/render/camera.h"
#include "pvol/render/film.h"

namespace pvol {

namespace detail {
struct FramePlanes;
}

struct DenoiseOptions {
  int window = 6;          ///< pixels to each side that a pixel's neighbours come from, 1..32
  int patch = 3;           ///< pixels to each side that are compared around a neighbour, 0..8
  double bandwidth = 0.7;  ///< standard deviations by which patches may differ, above 0
  int threads = 0;         ///< 0: one for each hardware thread
  /// Asked now and then, from any thread; once it is true, the filter gives up.
  std::function<bool()> stop{};
};

/// A layer of a film that is a part of its colour, filtered: a value for each pixel.
struct FilteredLayer {
  std::size_t number = 0;  ///< among the film's layers
  std::vector<Vec3d> values;
};

/// A filtered picture: for each pixel of a film, by channel.
struct Denoised {
  std::vector<Vec3d> colour;
  /// Estimate of the variance of `colour`, smoothed over a neighbourhood; of pixels left as they
  /// were that of the film.
  std::vector<Vec3d> variance;
  /// Estimate of its mean squared error, bias included, likewise smoothed; at least the variance.
  /// It is good for regions: in one pixel noise hides what the filter may have lost.
  std::vector<Vec3d> mse;
  /// The root mean square over all pixels of the estimated error of their luminance, over the
  /// picture's mean luminance: beside `relative_noise` of the film. 0 without light.
  double relative_error = 0;
  /// Standard deviation of that estimate, were noise normal.
  double relative_error_deviation = 0;
  /// Pixels that rare samples made far brighter than all around them, and whose light was spread
  /// over their surroundings before the picture was filtered (T5.21).
  std::size_t fireflies = 0;
  /// The layers of Aov::lights and of Aov::scattering, as far as the film has them, filtered by the
  /// weights of the picture. Each of these sets sums up to `colour`, but for rounding (T5.22).
  std::vector<FilteredLayer> layers;
};

/// What a film must have been asked for to be filtered: `variance` and `samples` where it comes
/// from a file.
[[nodiscard]] AovSet denoising_aovs();

/// Filters the film's colour. Pixels around which, within two to each side, no sample collided or
/// there is no noise stay as they are. What is filtered is never negative, and lies within the
/// range of what the window has, fireflies spread. The same film gives the same bytes for any
/// number of threads. Throws Error for a film that lacks a layer, which it names, or has pixels of
/// fewer than two samples or that are not finite, for options out of range, and where it was
/// stopped.
[[nodiscard]] Denoised denoise(const Film& film, const DenoiseOptions& options = {});

/// A frame of a sequence, made ready for the filter: once for all frames that it bears upon. Holds
/// some 80 to 200 bytes a pixel, and not the film.
class FilterFrame {
 public:
  /// `camera` rendered the film at `time`, in frames; without a camera all frames count as seen by
  /// one that stands still, and velocities are not used. Throws as denoise does.
  explicit FilterFrame(const Film& film, const std::optional<Camera>& camera = std::nullopt,
                       const DenoiseOptions& options = {}, double time = 0);

 private:
  friend Denoised denoise(const Film& film, const FilterFrame& own,
                          std::span<const FilterFrame> others);
  DenoiseOptions options_;
  std::shared_ptr<const detail::FramePlanes> planes_;
};

/// Filters a frame with light from others, which come before and after it in the sequence: each
/// pixel is also estimated from those that show its point there, by the depth of first collisions,
/// their velocities if the film has Aov::velocity, and the cameras, and from what is around them.
/// What is elsewhere by more than the window, or changed, is left out by its looks. Noise falls
/// with the number of frames, and what is left of it hardly changes from frame to frame (T5.23).
/// `own` was made of `film`, and of all frames with the same options. Frames must have different
/// random numbers. Throws Error for frames that differ in size, crop or layers of light.
[[nodiscard]] Denoised denoise(const Film& film, const FilterFrame& own,
                               std::span<const FilterFrame> others);

/// The film as it is written: colour and its parts are the filtered ones, and variances are its
/// `mse`. Samples, alpha and all other layers are the film's; further layers have the colour that
/// was, `noisy`, and its variance, `noisy_variance`, with X, Y, Z for R, G, B because files round
/// what is colour.
[[nodiscard]] Film with_colour(const Film& film, const Denoised& denoised);

}  // namespace pvol
