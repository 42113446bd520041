// Films of known expectation, for tests of the filter.
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::test {

/// What a film of known truth is made of.
struct Truth {
  int width = 48, height = 40;
  int samples = 32;
  double noise = 0.5;  ///< standard deviation of a sample
  double rare = 0;     ///< share of samples that have all the light; 0 where noise is normal
  std::function<double(int x, int y)> light = [](int, int) { return 1.0; };
  std::function<double(int x, int y)> depth = [](int, int) { return 5.0; };
  std::function<double(int x, int y)> alpha = [](int, int) { return 1.0; };
  std::function<Vec3d(int x, int y)> velocity{};  ///< without it there is no such layer
  unsigned seed = 1;
};

inline Film make(const Truth& t) {
  Film f;
  f.width = f.crop_width = t.width, f.height = f.crop_height = t.height;
  const std::size_t pixels = std::size_t(t.width) * std::size_t(t.height);
  f.pixels.resize(pixels);
  for (const char* name : {"half_1", "half_2", "depth", "normal", "albedo"}) {
    f.layers.push_back({name, std::vector<Vec3d>(pixels), "RGB", std::vector<double>(pixels)});
  }
  f.layers[2].components = "Z", f.layers[3].components = "XYZ";
  if (t.velocity) {
    f.layers.push_back(
        {"velocity", std::vector<Vec3d>(pixels), "XYZ", std::vector<double>(pixels)});
  }
  std::mt19937 generator(t.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  for (std::size_t i = 0; i < pixels; ++i) {
    const int x = int(i) % t.width, y = int(i) / t.width;
    PixelSums& p = f.pixels[i];
    for (int n = 0; n < t.samples; ++n) {
      const double light = t.light(x, y);
      const bool bright = t.rare > 0 && uniform(generator) < t.rare;
      const Vec3d v = Vec3d(1, 2, 0.5) * (t.rare > 0 ? (bright ? light / t.rare : 0)
                                                     : light + t.noise * normal(generator));
      p.sum += v, p.sum_squares += v * v;
      f.layers[std::size_t(n % 2)].sums[i] += v;
      f.layers[std::size_t(n % 2)].weights[i] += 1;
      ++p.samples;
    }
    p.alpha = t.alpha(x, y) * p.samples;
    for (std::size_t k = 2; k < f.layers.size(); ++k) f.layers[k].weights[i] = p.alpha;
    f.layers[2].sums[i] = Vec3d(t.depth(x, y) * p.alpha);
    f.layers[3].sums[i] = Vec3d(0, 0, p.alpha);
    f.layers[4].sums[i] = Vec3d(p.alpha);
    if (t.velocity) f.layers[5].sums[i] = t.velocity(x, y) * p.alpha;
  }
  return f;
}

/// Root mean square of the red errors over the pixels for which `of` holds.
inline double error(
    const Truth& t, const std::vector<Vec3d>& colour,
    const std::function<bool(int x, int y)>& of = [](int, int) { return true; }) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const int x = int(i) % t.width, y = int(i) / t.width;
    if (!of(x, y)) continue;
    const double e = colour[i].x - t.light(x, y);
    sum += e * e, ++count;
  }
  return std::sqrt(sum / count);
}

inline std::vector<Vec3d> means(const Film& f) {
  std::vector<Vec3d> all;
  for (const PixelSums& p : f.pixels) all.push_back(mean(p));
  return all;
}

/// Adds to one sample of a pixel so many times the truth's light at one of so many pixels, by
/// chance. Returns the pixels.
inline std::vector<std::size_t> add_fireflies(Film& f, const Truth& t, double times, int among) {
  std::mt19937 generator(t.seed + 1000);
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < f.pixels.size(); ++i) {
    const auto number = generator();
    if (number % unsigned(among) != 0) continue;
    const Vec3d v = Vec3d(1, 2, 0.5) * (times * t.light(int(i) % t.width, int(i) / t.width));
    PixelSums& p = f.pixels[i];
    p.sum_squares += v * v + v * mean(p) * 2.0;
    p.sum += v;
    f.layers[number / unsigned(among) % 2].sums[i] += v;
    all.push_back(i);
  }
  return all;
}

/// Adds layers that sum up to the colour: `part` of the light in the first, and the rest.
inline void add_parts(Film& f, const Truth& t, const char* first, const char* second,
                      const std::function<double(int x, int y)>& part) {
  std::mt19937 generator(t.seed + 2000);
  std::normal_distribution<double> normal;
  Layer a{first, {}}, b{second, {}};
  for (std::size_t i = 0; i < f.pixels.size(); ++i) {
    const int x = int(i) % t.width, y = int(i) / t.width;
    const double n = f.pixels[i].samples;
    const double noise = t.noise * std::sqrt(n * part(x, y)) * normal(generator);
    // As much of the pixel's own noise as of its light, and some that both have against each other.
    a.sums.push_back(f.pixels[i].sum * part(x, y) + Vec3d(1, 2, 0.5) * (noise / 2));
    b.sums.push_back(f.pixels[i].sum - a.sums.back());
  }
  f.layers.push_back(std::move(a)), f.layers.push_back(std::move(b));
}

}  // namespace pvol::test
