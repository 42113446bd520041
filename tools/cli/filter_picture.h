// Filtering the noise of a rendered picture, for tools that render.
#pragma once

#include <functional>
#include <string>

#include "pvol/render/denoise.h"
#include "pvol/render/film.h"
#include "pvol/render/scene.h"

namespace pvol::cli {

/// The picture after the filter (pvol/render/denoise.h).
struct FilteredPicture {
  Film film;                  ///< with the noisy picture and its variance as layers
  double relative_error = 0;  ///< as estimated, and the estimate's standard deviation
  double relative_error_deviation = 0;
  std::size_t fireflies = 0;  ///< pixels whose rare bright light was spread
  double cpu_seconds = 0, wall_seconds = 0;
};

/// The film that was filtered, and what the filter says of it.
[[nodiscard]] FilteredPicture filtered_picture(const Film& film, const Denoised& d);

/// "estimated error 1.6 +- 0.3 % of the mean".
[[nodiscard]] std::string error_text(const FilteredPicture& filtered);

/// Layers that a picture needs to be filtered when it has been written, and that a frame of a
/// sequence needs besides for others to find what moves.
[[nodiscard]] AovSet layers_for_filter();
[[nodiscard]] AovSet layers_for_sequence();

/// The scene, rendered with all that the filter needs. Throws UsageError for one sample a pixel,
/// whose noise is not known.
[[nodiscard]] Scene with_needs_of_filter(const Scene& scene);

/// Filters a film of such a scene, and keeps of its layers those that `asked.aovs` has. Throws what
/// denoise throws, also once `stop` is true.
[[nodiscard]] FilteredPicture filter_picture(const Film& film, const RenderOptions& asked,
                                             const std::function<bool()>& stop);

}  // namespace pvol::cli
