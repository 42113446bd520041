#include "view/views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cli/film_layers.h"
#include "cli/film_samples.h"
#include "pvol/error.h"
#include "pvol/render/aov.h"
#include "report/colour_map.h"

namespace pvol::viewer {
namespace {

using cli::Plane;

constexpr const char *kColour = "colour", *kAlpha = "alpha";

/// The layers that one AOV brings have names of their own, which depend on the scene.
bool has_one_layer(const AovRow& row) {
  return row.aov != Aov::lights && row.aov != Aov::scattering && row.aov != Aov::halves &&
         row.aov != Aov::objects;
}

/// The layer, where the film has it.
std::optional<Plane> find_layer(const Film& film, const std::string& name) {
  if (name == kAlpha) {
    Plane plane;
    for (const PixelSums& p : film.pixels) {
      plane.values.push_back(p.samples ? float(p.alpha / p.samples) : 0);
    }
    return plane;
  }
  const AovSet figures = cli::figures_of_renders(true);
  const std::vector<std::string> names = cli::layer_names(film, figures);
  if (name == kColour || std::ranges::find(names, name) == names.end()) return std::nullopt;
  return cli::layer_of(film, figures, name);
}

/// A film of the window of another with these three components as its colours.
Film film_of(const Film& window, const Plane& plane) {
  Film film = window_of(window);
  film.pixels.resize(window.pixels.size());
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const float* v = &plane.values[3 * i];
    film.pixels[i].sum = {double(v[0]), double(v[1]), double(v[2])};
    film.pixels[i].samples = 1;
  }
  return film;
}

/// The value that this share of all lie below, of those that tell of something that was met.
double quantile(std::vector<float> values, double share) {
  std::erase_if(values, [](float v) { return !std::isfinite(v) || double(v) >= kNothingMet; });
  if (values.empty()) return 0;
  const auto place = std::ptrdiff_t(share * double(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + place);
  return double(values[std::size_t(place)]);
}

View view_numbers(const Film& film, const Plane& plane) {
  View view;
  view.lo = quantile(plane.values, 0.01), view.hi = quantile(plane.values, 0.99);
  if (!(view.hi > view.lo)) view.hi = view.lo + 1;
  view.has_scale = true;
  const std::vector<double> values(plane.values.begin(), plane.values.end());
  view.picture =
      cli::map_colours(values, film.crop_width, cli::ColourMap::sequential, view.lo, view.hi);
  return view;
}

/// Each component from -hi to hi as one from black to full.
View view_directions(const Film& film, const Plane& plane) {
  std::vector<float> sizes;
  for (const float v : plane.values) sizes.push_back(std::abs(v));
  View view;
  view.hi = quantile(std::move(sizes), 0.99);
  if (!(view.hi > 0)) view.hi = 1;
  view.lo = -view.hi;
  view.has_scale = true;
  view.picture = {film.crop_width, film.crop_height, {}};
  for (const float v : plane.values) {
    const double share = std::clamp(0.5 + 0.5 * double(v) / view.hi, 0.0, 1.0);
    view.picture.rgb.push_back(std::uint8_t(std::lround(255 * (std::isnan(share) ? 0 : share))));
  }
  return view;
}

/// Whether the layer's three components are light or other colours.
bool is_colour(const std::string& name) {
  const auto aov = find_named<Aov>(name);
  return !aov || (row(*aov).channels == std::string_view("RGB") && *aov != Aov::variance);
}

/// The variance of one number for three.
Plane to_luminance(const Plane& plane) {
  Plane grey;
  for (std::size_t i = 0; i + 2 < plane.values.size(); i += 3) {
    grey.values.push_back(
        luminance(Rgb(plane.values[i], plane.values[i + 1], plane.values[i + 2])));
  }
  return grey;
}

}  // namespace

std::vector<std::string> layers_to_view() {
  std::vector<std::string> names{kColour, kAlpha};
  for (const AovRow& row : kAovs) {
    if (has_one_layer(row)) names.emplace_back(row.name);
  }
  return names;
}

void check_layer(const std::string& layer) {
  if (std::ranges::count(layers_to_view(), layer) > 0) return;
  throw Error(fmt::format("there is no layer '{}'; expected {}", layer, listed(layers_to_view())));
}

AovSet needs_of_layer(const std::string& layer) {
  AovSet set;
  if (const auto aov = find_named<Aov>(layer)) set.add(*aov);
  return set;
}

View view_of(const Film& film, const ViewChoice& choice, const formats::Screen& screen) {
  const std::optional<Plane> plane = find_layer(film, choice.layer);
  if (!plane) return {.picture = to_picture(film, screen)};
  if (plane->components == 1) return view_numbers(film, *plane);
  if (choice.layer == row(Aov::variance).name) return view_numbers(film, to_luminance(*plane));
  if (!is_colour(choice.layer)) return view_directions(film, *plane);
  return {.picture = to_picture(film_of(film, *plane), screen)};
}

cli::Json describe_pixel(const Film& film, int x, int y) {
  const std::size_t i = film.index(x, y);
  const PixelSums& p = film.pixels[i];
  const Vec3d radiance = mean(p), variance = variance_of_mean(p);
  cli::Json j = {{"x", film.x + x},
                 {"y", film.y + y},
                 {"radiance", {radiance.x, radiance.y, radiance.z}},
                 {"alpha", p.samples ? p.alpha / p.samples : 0.0},
                 {"samples", p.samples}};
  if (p.samples > 1) {
    j["error"] = {std::sqrt(variance.x), std::sqrt(variance.y), std::sqrt(variance.z)};
  }
  for (const Layer& layer : film.layers) {
    const Vec3d v = value(layer, film, i);
    if (layer.components.size() == 1) {
      j["layers"][layer.name] = v.x;
    } else {
      j["layers"][layer.name] = {v.x, v.y, v.z};
    }
  }
  return j;
}

}  // namespace pvol::viewer
