// What the filter leaves of the flicker of a sequence, by frames that it takes light from:
//   flicker_bench NOISY.####.exr REFERENCE.####.exr FIRST LAST
// NOISY frames are rendered with --denoise-layers, REFERENCE frames with many samples. Flicker is
// by how much the error of a pixel's luminance changes from one frame to the next, over its
// luminance (but at least 1 % of the mean). It is printed for half of the pixels that show some of
// a cloud, and for 95 % of them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/denoise.h"

namespace {

using namespace pvol;

std::string file_of_frame(const std::string& pattern, int frame) {
  const std::size_t end = pattern.rfind('#') + 1;
  std::size_t begin = end;
  while (begin > 0 && pattern[begin - 1] == '#') --begin;
  std::string number = std::to_string(frame);
  number.insert(0, std::max(end - begin, number.size()) - number.size(), '0');
  return pattern.substr(0, begin) + number + pattern.substr(end);
}

struct Frame {
  Film noisy;
  FilterFrame ready;
  std::vector<double> truth;
};

Frame read(const std::string& noisy, const std::string& reference, int frame) {
  const formats::StoredFilm stored = formats::read_film(noisy);
  const auto scene = formats::parse_scene(stored.attributes.at("pvol:scene"), noisy);
  Frame f{stored.film,
          FilterFrame(stored.film, middle_camera(scene.scene.camera), {}, double(frame)),
          {}};
  for (const PixelSums& p : formats::read_film(reference).film.pixels) {
    f.truth.push_back(luminance(mean(p)));
  }
  if (f.truth.size() != f.noisy.pixels.size()) throw Error(noisy + ": differs in size");
  return f;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / double(values.size());
}

std::vector<double> errors_of(const Frame& f, const std::vector<Vec3d>& colour) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    errors.push_back(luminance(colour[i]) - f.truth[i]);
  }
  return errors;
}

std::vector<Vec3d> colour_of(const std::vector<Frame>& frames, std::size_t which, int around) {
  std::vector<Vec3d> noisy;
  for (const PixelSums& p : frames[which].noisy.pixels) noisy.push_back(mean(p));
  if (around < 0) return noisy;
  std::vector<FilterFrame> others;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i != which && std::abs(int(i) - int(which)) <= around) others.push_back(frames[i].ready);
  }
  return denoise(frames[which].noisy, frames[which].ready, others).colour;
}

double part(std::vector<double>& values, double share) {
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Of frames that have as many on both sides; `around` -1 is the noisy picture.
void print(const std::vector<Frame>& frames, int around, int margin) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<double> flicker, last;
  double squares = 0, light = 0, pixels = 0;
  for (std::size_t n = std::size_t(margin); n + std::size_t(margin) < frames.size(); ++n) {
    const Frame& f = frames[n];
    const double least = 0.01 * mean_of(f.truth);
    std::vector<double> errors = errors_of(f, colour_of(frames, n, around));
    for (std::size_t i = 0; i < errors.size(); ++i) {
      squares += errors[i] * errors[i], light += f.truth[i], ++pixels;
      if (!last.empty() && f.noisy.pixels[i].alpha > 0) {
        flicker.push_back(std::abs(errors[i] - last[i]) / std::max(least, f.truth[i]));
      }
    }
    last = std::move(errors);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const std::string name = around < 0 ? "noisy" : "+-" + std::to_string(around);
  std::printf(
      "%-6s  error %6.3f %%  flicker: median %6.3f %%, 95 %% below %6.3f %%  %5.1f us a pixel\n",
      name.c_str(), 100 * std::sqrt(squares / pixels) / (light / pixels), 100 * part(flicker, 0.5),
      100 * part(flicker, 0.95), 1e6 * took.count() / pixels);
}

void run(std::span<char*> given) {
  constexpr int kMost = 3;
  std::vector<Frame> frames;
  for (int n = std::atoi(given[2]); n <= std::atoi(given[3]); ++n) {
    frames.push_back(read(file_of_frame(given[0], n), file_of_frame(given[1], n), n));
  }
  if (frames.size() < 2 * kMost + 2) throw Error("expected at least 8 frames");
  for (int around = -1; around <= kMost; ++around) print(frames, around, kMost);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: flicker_bench NOISY.####.exr REFERENCE.####.exr FIRST LAST\n");
    return 2;
  }
  try {
    run({argv + 1, 4});
  } catch (const std::exception& e) {
    std::fprintf(stderr, "flicker_bench: error: %s\n", e.what());
    return 1;
  }
}
