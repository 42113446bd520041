// What the filter makes of a picture, against one of many samples:
//   filter_bench FILM.exr REFERENCE.exr
// FILM.exr is rendered with --aov variance,samples,transmittance,halves,depth,normal,albedo,
// perhaps with lights and scattering; REFERENCE.exr with another seed and --aov variance,samples,
// and with those. Errors are of luminance, over the mean luminance of the reference, whose noise is
// taken out.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/render/denoise.h"

namespace {

using namespace pvol;

std::vector<Vec3d> means(const Film& film) {
  std::vector<Vec3d> all;
  for (const PixelSums& p : film.pixels) all.push_back(mean(p));
  return all;
}

double mean_luminance(const std::vector<Vec3d>& colour) {
  double sum = 0;
  for (const Vec3d& c : colour) sum += luminance(c);
  return sum / double(colour.size());
}

/// relMSE weighs each pixel's error by its own brightness: squared error over
/// (luminance^2 + (1 % of the mean)^2). Black are channels that are 0 where the noisy picture is
/// not.
void print(const char* name, const std::vector<Vec3d>& colour, const Film& noisy,
           const Film& reference) {
  const double all = mean_luminance(means(reference));
  double squares = 0, relative = 0;
  int black = 0;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const double truth = luminance(mean(reference.pixels[i]));
    const Vec3d d = colour[i] - mean(reference.pixels[i]);
    const double square = luminance(d * d) - noise_of(reference.pixels[i]);
    squares += square, relative += square / (truth * truth + 1e-4 * all * all);
    for (int c = 0; c < 3; ++c) black += colour[i][c] == 0 && mean(noisy.pixels[i])[c] > 0;
  }
  const double n = double(colour.size());
  std::printf("%-8s  RMSE %6.3f %%  relMSE %.5f  mean %+.3f %%  black %d\n", name,
              100 * std::sqrt(squares / n) / all, relative / n,
              100 * (mean_luminance(colour) / all - 1), black);
}

void print_layer(const FilteredLayer& f, const Film& noisy, const Film& reference) {
  const Layer& layer = noisy.layers[f.number];
  const auto truth = std::ranges::find(reference.layers, layer.name, &Layer::name);
  if (truth == reference.layers.end()) return;
  const double all = mean_luminance(means(reference)), n = double(noisy.pixels.size());
  double before = 0, after = 0;
  for (std::size_t i = 0; i < noisy.pixels.size(); ++i) {
    const double is = luminance(value(*truth, reference, i));
    before += std::pow(luminance(value(layer, noisy, i)) - is, 2);
    after += std::pow(luminance(f.values[i]) - is, 2);
  }
  std::printf("  %-12s  RMSE %6.3f -> %6.3f %% of the picture's mean\n", layer.name.c_str(),
              100 * std::sqrt(before / n) / all, 100 * std::sqrt(after / n) / all);
}

void run(const char* film, const char* many_samples) {
  const Film noisy = formats::read_film(film).film;
  const Film reference = formats::read_film(many_samples).film;
  if (noisy.pixels.size() != reference.pixels.size()) throw Error("the pictures differ in size");
  const auto begin = std::chrono::steady_clock::now();
  const Denoised d = denoise(noisy, {.threads = 1});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  print("noisy", means(noisy), noisy, reference);
  print("filtered", d.colour, noisy, reference);
  std::printf("estimated %.3f %%; fireflies in %zu pixels; %.1f us a pixel\n",
              100 * d.relative_error, d.fireflies,
              1e6 * took.count() / double(noisy.pixels.size()));
  for (const FilteredLayer& f : d.layers) print_layer(f, noisy, reference);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "filter_bench FILM.exr REFERENCE.exr\n");
    return 2;
  }
  try {
    run(argv[1], argv[2]);
  } catch (const Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
