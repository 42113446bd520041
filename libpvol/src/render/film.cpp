#include "pvol/render/film.h"

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
  double noise = 0, light = 0;
  for (const PixelSums& p : film.pixels) {
    if (p.samples < 2) return std::nullopt;
    noise += noise_of(p);
    light += double(luminance(Rgb(mean(p))));
  }
  if (!(light > 0)) return 0;
  return std::sqrt(noise * double(film.pixels.size())) / light;
}

void add_samples(Film& to, const Film& from) {
  if (from.pixels.size() != to.pixels.size() || from.crop_width != to.crop_width ||
      from.layers.size() != to.layers.size()) {
    throw Error("films of different sizes or layers cannot be added");
  }
  add_samples(to.deep, from.deep);
  for (std::size_t i = 0; i < to.pixels.size(); ++i) {
    PixelSums& p = to.pixels[i];
    const PixelSums& q = from.pixels[i];
    p.sum += q.sum, p.sum_squares += q.sum_squares, p.alpha += q.alpha;
    p.samples += q.samples;
    for (std::size_t k = 0; k < p.counts.size(); ++k) p.counts[k] += q.counts[k];
  }
  for (std::size_t k = 0; k < to.layers.size(); ++k) add(to.layers[k], from.layers[k]);
}

}  // namespace pvol
