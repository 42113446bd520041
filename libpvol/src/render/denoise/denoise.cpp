#include "pvol/render/denoise.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/workers.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"
#include "render/denoise/filter_error.h"
#include "render/denoise/frame_planes.h"
#include "render/denoise/regression.h"

namespace pvol {
namespace {

using detail::Errors;
using detail::FramePlanes;
using detail::Halves;
using detail::Plane;
using detail::Planes;
using detail::Predictions;
using detail::Tile;
using detail::WindowValues;
using detail::Workers;

void check(const DenoiseOptions& o) {
  constexpr int kMostWindow = 32, kMostPatch = 8;
  if (o.window < 1 || o.window > kMostWindow)
    throw Error("denoise: window is out of range; expected 1 to 32");
  if (o.patch < 0 || o.patch > kMostPatch)
    throw Error("denoise: patch is out of range; expected 0 to 8");
  if (!(o.bandwidth > 0) || !std::isfinite(o.bandwidth)) {
    throw Error("denoise: bandwidth is out of range; expected a number above 0");
  }
  if (o.threads < 0) throw Error("denoise: threads is negative; expected 0 or more");
}

bool any_filtered(const Plane& filtered, const Tile& t) {
  for (int y = t.y; y < t.y + t.height; ++y) {
    const float* r = filtered.row(y) + t.x;
    if (std::any_of(r, r + t.width, [](float f) { return f > 0; })) return true;
  }
  return false;
}

/// What is known of the pixels of some planes, by plane.
struct Filtered {
  Planes sums;                                       ///< of predictions times weights
  Plane weights;                                     ///< their sums
  std::vector<std::vector<WindowValues>> windows{};  ///< by pixels, in rows

  Filtered(std::size_t planes, int width, int height)
      : sums(planes, Plane(width, height, 0)),
        weights(width, height, 0),
        windows(planes, std::vector<WindowValues>(std::size_t(width) * std::size_t(height))) {}
};

/// Adds a plane of what is predicted around a tile.
void add(const std::vector<float>& from, int edge, const Tile& t, int window, Plane& to) {
  const int y0 = std::max(0, t.y - window), y1 = std::min(to.height(), t.y + t.height + window);
  const int x0 = std::max(0, t.x - window), x1 = std::min(to.width(), t.x + t.width + window);
  for (int y = y0; y < y1; ++y) {
    const float* row = from.data() + std::ptrdiff_t(y - t.y + window) * edge - t.x + window;
    for (int x = x0; x < x1; ++x) to.row(y)[x] += row[x];
  }
}

void add(const Predictions& p, const Tile& t, int window, std::size_t c, Filtered& to) {
  if (c == to.sums.size()) return add(p.weights, p.edge, t, window, to.weights);
  add(p.sums[c], p.edge, t, window, to.sums[c]);
  for (int y = 0; y < t.height; ++y) {
    const std::size_t at =
        std::size_t(t.y + y) * std::size_t(to.weights.width()) + std::size_t(t.x);
    std::copy_n(p.windows[c].begin() + y * detail::kTile, t.width,
                to.windows[c].begin() + std::ptrdiff_t(at));
  }
}

/// The value, but where it lies beyond what the window has one that has gone back towards the
/// window's mean: far enough to be no extreme of it.
float credible(const WindowValues& w, float value) {
  constexpr float kShort = 0.9f;  // of the extreme
  if (value > w.most) return w.mean + kShort * (w.most - w.mean);
  if (value < w.least) return w.mean - kShort * (w.mean - w.least);
  return value;
}

/// The means of the predictions, as far as they are credible.
Planes finish(Filtered f) {
  const int width = f.weights.width();
  for (std::size_t c = 0; c < f.sums.size(); ++c) {
    for (int y = 0; y < f.weights.height(); ++y) {
      const WindowValues* windows = f.windows[c].data() + std::ptrdiff_t(y) * width;
      const float* weights = f.weights.row(y);
      float* to = f.sums[c].row(y);
      for (int x = 0; x < width; ++x) {
        to[x] = weights[x] > 0 ? credible(windows[x], to[x] / weights[x]) : 0;
      }
    }
  }
  return std::move(f.sums);
}

/// Colours of one half, or of all samples, with weights from a half. Tiles are added up in their
/// order, so many at a time that those of all need not be held.
Planes filter_by(const detail::RegressionInput& in, const Plane& where,
                 const std::function<bool()>& stop) {
  constexpr std::size_t kTogether = 256;
  const int width = where.width(), height = where.height();
  const std::size_t tiles = detail::tiles_in(width, height), planes = in.own.colours.size();
  Filtered all(planes, width, height);
  for (std::size_t first = 0; first < tiles; first += kTogether) {
    std::vector<Predictions> parts(std::min(kTogether, tiles - first));
    parallel_for(0, parts.size(), [&](std::size_t i) {
      detail::heed(stop);
      const Tile t = detail::tile_of(first + i, width, height);
      if (any_filtered(where, t)) parts[i] = detail::regress(in, t);
    });
    parallel_for(0, planes + 1, [&](std::size_t c) {
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const Tile t = detail::tile_of(first + i, width, height);
        if (parts[i].edge > 0) add(parts[i], t, in.options.window, c, all);
      }
    });
  }
  return finish(std::move(all));
}

/// One channel of the result, where the picture was filtered.
void put(const Film& film, const Halves& halves, const std::array<Planes, 2>& filtered, int c,
         const Errors& errors, Denoised& out) {
  const double scale = halves.scale, scale2 = scale * scale;
  const auto channel = std::size_t(c);
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      if (!(halves.filtered.row(y)[x] > 0)) continue;
      const std::size_t i = film.index(x, y);
      const double both =
          double(filtered[0][channel].row(y)[x]) + double(filtered[1][channel].row(y)[x]);
      out.colour[i][c] = std::max(0.0, both / 2) * scale;
      out.variance[i][c] = double(errors.variance.row(y)[x]) * scale2;
      out.mse[i][c] = double(errors.mse.row(y)[x]) * scale2;
    }
  }
}

/// Finds the error of the whole. The errors of the pixels that were left are added to those of all
/// the others together, which are known better than the parts.
void add_relative_error(const Halves& halves, Vec3d mean_mse, Vec3d deviation, Denoised& d) {
  const Plane& filtered = halves.filtered;
  double errors = 0, uncertain = 0, light = 0;
  for (std::size_t i = 0; i < d.colour.size(); ++i) {
    const auto width = std::size_t(filtered.width());
    const bool left = !(filtered.row(int(i / width))[i % width] > 0);
    errors += luminance(left ? d.mse[i] : mean_mse), light += luminance(d.colour[i]);
    if (!left) uncertain += luminance(deviation);  // as if the channels had the same noise
  }
  if (!(light > 0) || !(errors > 0)) return;
  d.relative_error = std::sqrt(errors * double(d.colour.size())) / light;
  d.relative_error_deviation = d.relative_error * uncertain / (2 * errors);
}

/// One half of a frame and, after its colour, the parts of that, of all samples; weights are from
/// the other half.
detail::FrameInput input_of(const std::array<detail::Guide, 2>& colour, const Planes& parts,
                            const Planes& features, const Plane* known, std::size_t half) {
  detail::FrameInput in{&colour[1 - half], {}, &features, known};
  for (const Plane& p : colour[half].values) in.colours.push_back(&p);
  for (const Plane& p : parts) in.colours.push_back(&p);
  return in;
}

/// The planes of both halves, each with weights from the other.
std::array<Planes, 2> filter_halves(const FramePlanes& own,
                                    const std::vector<detail::AlignedFrame>& others,
                                    const std::function<bool()>& stop) {
  std::array<Planes, 2> filtered;
  for (const std::size_t half : {0u, 1u}) {
    detail::RegressionInput in{
        input_of(own.halves.colour, own.parts, own.features.planes, nullptr, half),
        {},
        own.patches};
    for (const detail::AlignedFrame& f : others) {
      in.others.push_back(input_of(f.colour, f.parts, f.features, &f.known, half));
    }
    filtered[half] = filter_by(in, own.halves.filtered, stop);
  }
  return filtered;
}

Denoised filter(const Film& film, const FramePlanes& own,
                const std::vector<const FramePlanes*>& others, const std::function<bool()>& stop) {
  Denoised out;
  for (const PixelSums& p : film.pixels) {
    out.colour.push_back(mean(p));
    out.variance.push_back(variance_of_mean(p));
  }
  out.mse = out.variance;
  const Halves& halves = own.halves;
  out.fireflies = halves.fireflies.pixels;
  Vec3d mean_mse, deviation;
  if (halves.any) {
    const auto sets = detail::find_colour_parts(film);
    std::vector<detail::AlignedFrame> aligned;
    for (const FramePlanes* other : others) aligned.push_back(detail::align(*other, own));
    const std::array<Planes, 2> filtered = filter_halves(own, aligned, stop);
    for (int c = 0; c < 3; ++c) {
      const Errors errors = detail::find_errors(halves, filtered, std::size_t(c));
      put(film, halves, filtered, c, errors, out);
      mean_mse[c] = errors.mean_mse * halves.scale * halves.scale;
      deviation[c] = errors.deviation * halves.scale * halves.scale;
    }
    out.layers = detail::fit_parts(film, sets, halves,
                                   {filtered[0].data() + 3, filtered[1].data() + 3}, out.colour);
  }
  add_relative_error(halves, mean_mse, deviation, out);
  return out;
}

/// A layer whose values are `of(pixel)`, which are means over the samples.
template <class F>
void add_layer(Film& film, const char* name, const char* components, const F& of) {
  Layer layer{name, {}, components};
  for (const PixelSums& p : film.pixels) layer.sums.push_back(of(p) * double(p.samples));
  film.layers.push_back(std::move(layer));
}

}  // namespace

Film with_colour(const Film& film, const Denoised& d) {
  Film out = film;
  out.remainders = {};
  add_layer(out, kNoisyLayers[0], "RGB", [](const PixelSums& p) { return mean(p); });
  add_layer(out, kNoisyLayers[1], "XYZ", variance_of_mean);
  for (const FilteredLayer& f : d.layers) {
    for (std::size_t i = 0; i < out.pixels.size(); ++i) {
      out.layers[f.number].sums[i] = f.values[i] * double(out.pixels[i].samples);
    }
  }
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    PixelSums& p = out.pixels[i];
    const double n = p.samples;
    p.sum = d.colour[i] * n;
    p.sum_squares = d.mse[i] * (n * (n - 1)) + p.sum * d.colour[i];
  }
  return out;
}

FilterFrame::FilterFrame(const Film& film, const std::optional<Camera>& camera,
                         const DenoiseOptions& o, double time)
    : options_(o) {
  check(o);
  detail::check_film(film);
  if (film.pixels.empty()) throw Error("denoise: the film has no pixels");
  const detail::PatchOptions patches{o.window, o.patch, float(o.bandwidth)};
  Workers(o.threads).arena.execute([&] {
    planes_ = std::make_shared<FramePlanes>(
        detail::make_frame_planes(film, patches, {camera, time}, o.stop));
  });
}

Denoised denoise(const Film& film, const FilterFrame& own, std::span<const FilterFrame> others) {
  std::vector<const FramePlanes*> planes;
  for (const FilterFrame& f : others) planes.push_back(f.planes_.get());
  Denoised out;
  Workers(own.options_.threads).arena.execute([&] {
    out = filter(film, *own.planes_, planes, own.options_.stop);
  });
  return out;
}

Denoised denoise(const Film& film, const DenoiseOptions& o) {
  if (film.pixels.empty()) {
    check(o);
    detail::check_film(film);
    return {};
  }
  return denoise(film, FilterFrame(film, std::nullopt, o), {});
}

}  // namespace pvol
