#include "pvol/render/film.h"

#include <algorithm>
#include <cmath>

#include "pvol/error.h"

namespace pvol {
namespace {

void add(Layer& to, const Layer& from) {
  for (std::size_t i = 0; i < to.sums.size(); ++i) {
    to.sums[i] = to.least ? min(to.sums[i], from.sums[i]) : to.sums[i] + from.sums[i];
  }
  for (std::size_t i = 0; i < to.weights.size(); ++i) to.weights[i] += from.weights[i];
}

/// Adds pixel j of some sums to pixel i.
void merge(FilmSums& to, std::size_t i, const FilmSums& from, std::size_t j) {
  to.pixels[i].light.merge(from.pixels[j].light);
  to.pixels[i].squares.merge(from.pixels[j].squares);
  to.pixels[i].alpha.merge(from.pixels[j].alpha);
  for (std::size_t k = 0; k < to.layers.size(); ++k) {
    ExactLayer& layer = to.layers[k];
    if (!layer.sums.empty()) layer.sums[i].merge(from.layers[k].sums[j]);
    if (!layer.weights.empty()) layer.weights[i].merge(from.layers[k].weights[j]);
  }
}

void add_counts(PixelSums& to, const PixelSums& from) {
  to.samples += from.samples;
  for (std::size_t k = 0; k < to.counts.size(); ++k) to.counts[k] += from.counts[k];
}

bool have_same_layers(const Film& a, const Film& b) {
  const auto same = [](const Layer& x, const Layer& y) {
    return x.name == y.name && x.components == y.components && x.least == y.least &&
           x.weights.empty() == y.weights.empty();
  };
  return std::ranges::equal(a.layers, b.layers, same);
}

/// Rows of a rectangle of a film that is `width` wide.
template <class T>
std::vector<T> cut(const std::vector<T>& all, std::size_t width, const Film& part,
                   std::size_t first) {
  std::vector<T> some;
  if (all.empty()) return some;
  some.reserve(part.pixels.size());
  for (int y = 0; y < part.crop_height; ++y) {
    const auto row = all.begin() + std::ptrdiff_t(first + std::size_t(y) * width);
    some.insert(some.end(), row, row + part.crop_width);
  }
  return some;
}

/// The sum of the pixels' luminance, at least 0, of a film whose noise is known: none where a pixel
/// has fewer than two samples.
std::optional<double> total_luminance(const Film& film) {
  double light = 0;
  for (const PixelSums& p : film.pixels) {
    if (p.samples < 2) return std::nullopt;
    light += double(luminance(Rgb(mean(p))));
  }
  return light > 0 ? light : 0;
}

}  // namespace

Vec3d value(const Layer& layer, const Film& film, std::size_t pixel) {
  const Vec3d sum = layer.sums[pixel];
  if (layer.least) return sum;
  const double weight =
      layer.weights.empty() ? double(film.pixels[pixel].samples) : layer.weights[pixel];
  if (weight > 0) return sum / weight;
  return layer.components == "Z" ? Vec3d(kNothingMet) : Vec3d{};
}

std::optional<double> relative_noise(const Film& film) {
  const std::optional<double> light = total_luminance(film);
  if (!light || !(*light > 0)) return light;
  double noise = 0;
  for (const PixelSums& p : film.pixels) noise += noise_of(p);
  return std::sqrt(noise * double(film.pixels.size())) / *light;
}

std::optional<double> pixel_noise(const Film& film) {
  const std::optional<double> light = total_luminance(film);
  if (!light || !(*light > 0)) return light;
  const double pixels = double(film.pixels.size());
  double sum = 0;
  for (const PixelSums& p : film.pixels) {
    sum += noise_of(p) / squared_unit_of_noise(double(luminance(Rgb(mean(p)))), *light / pixels);
  }
  return std::sqrt(sum / pixels);
}

void start_sums(Film& film) {
  film.sums.pixels.assign(film.pixels.size(), {});
  film.sums.layers.clear();
  for (const Layer& layer : film.layers) {
    film.sums.layers.push_back({std::vector<Sum3>(layer.least ? 0 : layer.sums.size()),
                                std::vector<Sum1>(layer.least ? 0 : layer.weights.size())});
  }
}

void flush(Film& film, std::size_t pixel) {
  PixelSums& p = film.pixels[pixel];
  const ExactPixel& exact = film.sums.pixels[pixel];
  p.sum = value(exact.light), p.sum_squares = value(exact.squares), p.alpha = value(exact.alpha);
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    const ExactLayer& from = film.sums.layers[k];
    if (!from.sums.empty()) film.layers[k].sums[pixel] = value(from.sums[pixel]);
    if (!from.weights.empty()) film.layers[k].weights[pixel] = value(from.weights[pixel]);
  }
}

Film crop_of(const Film& film, int x, int y, int width, int height) {
  Film part{film.width, film.height, x, y, width, height, {}};
  part.first_sample = film.first_sample;
  part.color_space = film.color_space;
  part.pixels.resize(std::size_t(width) * std::size_t(height));
  const std::size_t first = film.index(x - film.x, y - film.y);
  const auto rows = [&](const auto& all) {
    return cut(all, std::size_t(film.crop_width), part, first);
  };
  part.pixels = rows(film.pixels);
  part.sums.pixels = rows(film.sums.pixels);
  for (const Layer& layer : film.layers) {
    part.layers.push_back(
        {layer.name, rows(layer.sums), layer.components, rows(layer.weights), layer.least});
  }
  for (const ExactLayer& layer : film.sums.layers) {
    part.sums.layers.push_back({rows(layer.sums), rows(layer.weights)});
  }
  return part;
}

void add_part(Film& to, const Film& part) {
  const int x = part.x - to.x, y = part.y - to.y;
  if (to.width != part.width || to.height != part.height || x < 0 || y < 0 ||
      x + part.crop_width > to.crop_width || y + part.crop_height > to.crop_height) {
    throw Error("the part lies outside the film; expected a rectangle inside it");
  }
  if (!have_same_layers(to, part) || to.color_space != part.color_space || to.sums.empty() ||
      part.sums.empty()) {
    throw Error(
        "the part has other layers or another colour space than the film, or no exact sums; "
        "expected the same layers and space with sums");
  }
  for (int row = 0; row < part.crop_height; ++row) {
    for (int column = 0; column < part.crop_width; ++column) {
      const std::size_t i = to.index(x + column, y + row), j = part.index(column, row);
      merge(to.sums, i, part.sums, j);
      add_counts(to.pixels[i], part.pixels[j]);
      for (std::size_t k = 0; k < to.layers.size(); ++k) {
        Layer& layer = to.layers[k];
        if (layer.least) layer.sums[i] = min(layer.sums[i], part.layers[k].sums[j]);
      }
    }
  }
}

void add_samples(Film& to, const Film& from) {
  if (from.pixels.size() != to.pixels.size() || from.crop_width != to.crop_width ||
      from.layers.size() != to.layers.size() || from.color_space != to.color_space) {
    throw Error(
        "the films have different sizes, layers or colour spaces; expected the same to add them");
  }
  const bool exact = !to.sums.empty() && !from.sums.empty();
  if (exact) {
    for (std::size_t i = 0; i < to.pixels.size(); ++i) merge(to.sums, i, from.sums, i);
  } else {
    to.sums = {};
  }
  add_samples(to.deep, from.deep);
  for (std::size_t i = 0; i < to.pixels.size(); ++i) {
    PixelSums& p = to.pixels[i];
    const PixelSums& q = from.pixels[i];
    p.sum += q.sum, p.sum_squares += q.sum_squares, p.alpha += q.alpha;
    add_counts(p, q);
  }
  for (std::size_t k = 0; k < to.layers.size(); ++k) add(to.layers[k], from.layers[k]);
  for (std::size_t i = 0; exact && i < to.pixels.size(); ++i) flush(to, i);
}

}  // namespace pvol
