// A film as a page shows it: its colours, or one of its layers.
#pragma once

#include <string>
#include <vector>

#include "cli/json.h"
#include "pvol/formats/image.h"

namespace pvol::viewer {

/// How a film is shown.
struct ViewChoice {
  std::string layer = "colour";  ///< or a name of `layers_to_view`
  formats::Display display{};    ///< of light
};

/// Names of what there is to show: "colour", "alpha", and all layers that can be asked for.
[[nodiscard]] std::vector<std::string> layers_to_view();

/// Throws Error for a name that is none of these.
void check_layer(const std::string& layer);

/// The AOV that a film must have for this layer to be shown; none where every film has it.
[[nodiscard]] AovSet needs_of_layer(const std::string& layer);

struct View {
  formats::Picture picture;
  /// Of a layer of numbers or of directions: what its darkest and its brightest colour stand for.
  double lo = 0, hi = 0;
  bool has_scale = false;
};

/// Light as write_png would write it by that screen, numbers by colours from dark blue to yellow
/// between their 1st and 99th percentile, directions as colours of their three components. A film
/// that lacks the layer is shown by its colours.
[[nodiscard]] View view_of(const Film& film, const ViewChoice& choice,
                           const formats::Screen& screen);

/// The values of a pixel: radiance, its standard error, alpha, samples and what layers have.
[[nodiscard]] cli::Json describe_pixel(const Film& film, int x, int y);

}  // namespace pvol::viewer
