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

/// Adds pixel j of a film with the same layers to pixel i, both with exact sums.
class PixelAdder {
 public:
  void add(const Film& from, std::size_t j, Film& to, std::size_t i) {
    load_sums(from, j, more_);
    load_sums(to, i, sums_);
    sums_.merge(more_);
    to.pixels[i].samples += from.pixels[j].samples;
    to.pixels[i].group_samples += from.pixels[j].group_samples;
    make_room(to.pixels[i].samples, to);
    store_sums(sums_, i, to);
    for (std::size_t k = 0; k < to.layers.size(); ++k) {
      Layer& layer = to.layers[k];
      if (layer.least) layer.sums[i] = min(layer.sums[i], from.layers[k].sums[j]);
    }
  }

 private:
  ExactSums sums_, more_;  // whose memory is used again
};

void add_counts(const Film& from, std::size_t j, Film& to, std::size_t i) {
  if (from.counts.empty()) return;
  to.counts.resize(to.pixels.size());
  for (std::size_t k = 0; k < kPixelCounts.size(); ++k) to.counts[i][k] += from.counts[j][k];
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

double luminance_variance(const Film& film, std::size_t pixel) {
  constexpr std::uint32_t kLeastSamples = 8;  // fewer are far less even than all of them
  constexpr std::size_t kLeastPixels = 100;   // the film's noise to 7 %
  const PixelSums& p = film.pixels[pixel];
  const double n = p.samples, a = p.group_samples, b = n - a;
  const double as_if_independent = noise_of(p);
  // Where that is 0, sums may have been rounded.
  const bool are_few = film.pixels.size() < kLeastPixels || std::min(a, b) < kLeastSamples;
  if (are_few || as_if_independent == 0) return as_if_independent;
  const double difference = p.group / a - (luminance(p.sum) - p.group) / b;
  return difference * difference * (a / n) * (b / n);
}

std::optional<double> relative_noise(const Film& film) {
  const std::optional<double> light = total_luminance(film);
  if (!light || !(*light > 0)) return light;
  double noise = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) noise += luminance_variance(film, i);
  return std::sqrt(noise * double(film.pixels.size())) / *light;
}

std::optional<double> pixel_noise(const Film& film) {
  const std::optional<double> light = total_luminance(film);
  if (!light || !(*light > 0)) return light;
  const double pixels = double(film.pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const double brightness = luminance(Rgb(mean(film.pixels[i])));
    sum += luminance_variance(film, i) / squared_unit_of_noise(brightness, *light / pixels);
  }
  return std::sqrt(sum / pixels);
}

void ExactSums::merge(const ExactSums& other) {
  light.merge(other.light), squares.merge(other.squares), alpha.merge(other.alpha);
  group.merge(other.group);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    layers[k].sum.merge(other.layers[k].sum), layers[k].weight.merge(other.layers[k].weight);
  }
}

void keep_exact_sums(Film& film) {
  film.remainders = {};
  film.remainders.pixels.resize(film.pixels.size());
  for (const Layer& layer : film.layers) {
    LayerRemainders& r = film.remainders.layers.emplace_back();
    if (!layer.least) r.sums.resize(layer.sums.size()), r.weights.resize(layer.weights.size());
  }
}

void make_room(std::uint32_t samples, Film& film) {
  if (samples <= kMostPacked || !film.remainders.whole.empty()) return;
  std::vector<ExactSums> whole(film.pixels.size());
  for (std::size_t i = 0; i < whole.size(); ++i) load_sums(film, i, whole[i]);
  film.remainders = {.whole = std::move(whole)};
}

void load_sums(const Film& film, std::size_t pixel, ExactSums& sums) {
  if (!film.remainders.whole.empty()) {
    sums = film.remainders.whole[pixel];
    return;
  }
  const PixelSums& p = film.pixels[pixel];
  const PixelRemainders& r = film.remainders.pixels[pixel];
  sums.light = restored(p.sum, r.light), sums.squares = restored(p.sum_squares, r.squares);
  sums.alpha = restored(p.alpha, r.alpha), sums.group = restored(p.group, r.group);
  sums.layers.resize(film.layers.size());
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    const LayerRemainders& of = film.remainders.layers[k];
    const Layer& layer = film.layers[k];
    sums.layers[k] = {};
    if (!of.sums.empty()) sums.layers[k].sum = restored(layer.sums[pixel], of.sums[pixel]);
    if (of.weights.empty()) continue;
    sums.layers[k].weight = restored(layer.weights[pixel], of.weights[pixel]);
  }
}

void store_sums(const ExactSums& sums, std::size_t pixel, Film& film) {
  PixelSums& p = film.pixels[pixel];
  p.sum = value(sums.light), p.sum_squares = value(sums.squares);
  p.alpha = value(sums.alpha), p.group = value(sums.group);
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    Layer& layer = film.layers[k];
    if (layer.least) continue;
    layer.sums[pixel] = value(sums.layers[k].sum);
    if (!layer.weights.empty()) layer.weights[pixel] = value(sums.layers[k].weight);
  }
  if (!film.remainders.whole.empty()) {
    film.remainders.whole[pixel] = sums;
    return;
  }
  film.remainders.pixels[pixel] = {sums.light.remainder(), sums.squares.remainder(),
                                   sums.alpha.remainder(), sums.group.remainder()};
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    LayerRemainders& to = film.remainders.layers[k];
    if (!to.sums.empty()) to.sums[pixel] = sums.layers[k].sum.remainder();
    if (!to.weights.empty()) to.weights[pixel] = sums.layers[k].weight.remainder();
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
  part.counts = rows(film.counts);
  part.remainders.pixels = rows(film.remainders.pixels);
  part.remainders.whole = rows(film.remainders.whole);
  for (const Layer& layer : film.layers) {
    part.layers.push_back(
        {layer.name, rows(layer.sums), layer.components, rows(layer.weights), layer.least});
  }
  for (const LayerRemainders& layer : film.remainders.layers) {
    part.remainders.layers.push_back({rows(layer.sums), rows(layer.weights)});
  }
  return part;
}

namespace {

std::string rectangle_text(const Film& f) {
  const auto pair = [](const char* between, int a, int b) {
    return std::to_string(a) + between + std::to_string(b);
  };
  return pair(" x ", f.crop_width, f.crop_height) + " pixels at (" + pair(", ", f.x, f.y) +
         ") of " + pair(" x ", f.width, f.height);
}

}  // namespace

void add_part(Film& to, const Film& part) {
  const int x = part.x - to.x, y = part.y - to.y;
  if (to.width != part.width || to.height != part.height || x < 0 || y < 0 ||
      x + part.crop_width > to.crop_width || y + part.crop_height > to.crop_height) {
    throw Error("the part shows " + rectangle_text(part) + ", expected a rectangle inside " +
                rectangle_text(to));
  }
  if (!have_same_layers(to, part) || to.color_space != part.color_space || to.remainders.empty() ||
      part.remainders.empty()) {
    throw Error(
        "the part has other layers or another colour space than the film, or no exact sums; "
        "expected the same layers and space with sums");
  }
  PixelAdder adder;
  for (int row = 0; row < part.crop_height; ++row) {
    for (int column = 0; column < part.crop_width; ++column) {
      const std::size_t i = to.index(x + column, y + row), j = part.index(column, row);
      adder.add(part, j, to, i);
      add_counts(part, j, to, i);
    }
  }
}

void add_samples(Film& to, const Film& from) {
  if (from.pixels.size() != to.pixels.size() || from.crop_width != to.crop_width ||
      !have_same_layers(from, to) || from.color_space != to.color_space) {
    throw Error(
        "the films have different sizes, layers or colour spaces; expected the same to add them");
  }
  add_samples(to.deep, from.deep);
  for (std::size_t i = 0; i < to.pixels.size(); ++i) add_counts(from, i, to, i);
  if (!to.remainders.empty() && !from.remainders.empty()) {
    PixelAdder adder;
    for (std::size_t i = 0; i < to.pixels.size(); ++i) adder.add(from, i, to, i);
    return;
  }
  to.remainders = {};
  for (std::size_t i = 0; i < to.pixels.size(); ++i) {
    PixelSums& p = to.pixels[i];
    const PixelSums& q = from.pixels[i];
    p.sum += q.sum, p.sum_squares += q.sum_squares, p.alpha += q.alpha;
    p.samples += q.samples, p.group += q.group, p.group_samples += q.group_samples;
  }
  for (std::size_t k = 0; k < to.layers.size(); ++k) add(to.layers[k], from.layers[k]);
}

}  // namespace pvol
