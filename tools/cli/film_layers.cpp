#include "cli/film_layers.h"

#include <algorithm>

#include "pvol/error.h"
#include "pvol/math/value.h"
#include "pvol/render/film_channels.h"

namespace pvol::cli {
namespace {

bool has_row(const FilmChannel& c, const std::string& name) {
  return c.aov && row(*c.aov).name == name;
}

Plane plane_of(const Film& film, const Layer& layer) {
  Plane plane{.components = int(layer.components.size())};
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const Vec3d v = value(layer, film, i);
    for (int k = 0; k < plane.components; ++k) plane.values.push_back(float(v[k]));
  }
  return plane;
}

}  // namespace

AovSet figures_of_renders(bool counted) {
  AovSet figures;
  for (const FilmChannel& c : kFilmChannels) {
    if (c.aov && (counted || !row(*c.aov).counted)) figures.add(*c.aov);
  }
  return figures;
}

std::vector<std::string> layer_names(const Film& film, AovSet figures) {
  std::vector<std::string> names;
  for (const FilmChannel& c : kFilmChannels) {
    if (!c.aov || !figures.has(*c.aov)) continue;
    if (names.empty() || names.back() != row(*c.aov).name) names.emplace_back(row(*c.aov).name);
  }
  for (const Layer& layer : film.layers) names.push_back(layer.name);
  return names;
}

Plane layer_of(const Film& film, AovSet figures, const std::string& name) {
  const std::vector<std::string> known = layer_names(film, figures);
  if (std::ranges::find(known, name) == known.end()) {
    throw Error("the picture has no layer '" + name + "'; it has " + listed(known) +
                ". Render it with others by aov=[...]");
  }
  for (const Layer& layer : film.layers) {
    if (layer.name == name) return plane_of(film, layer);
  }
  std::vector<const FilmChannel*> channels;
  for (const FilmChannel& c : kFilmChannels) {
    if (has_row(c, name)) channels.push_back(&c);
  }
  Plane plane{.components = int(channels.size())};
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    for (const FilmChannel* c : channels) plane.values.push_back(float(c->get(film, i)));
  }
  return plane;
}

}  // namespace pvol::cli
