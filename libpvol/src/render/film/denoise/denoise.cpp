#include "pvol/render/denoise.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/parallel.h"
#include "pvol/error.h"
#include "render/film/denoise/denoise_inputs.h"
#include "render/film/denoise/regression.h"

namespace pvol {
namespace {

using detail::Halves;
using detail::kTile;
using detail::Plane;
using detail::Planes;
using detail::Predictions;
using detail::Tile;

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

/// The picture from what all tiles say of their surroundings, added up in the order of the tiles.
Planes join(const std::vector<Predictions>& parts, int width, int height, int window) {
  Planes out;
  for (std::size_t c = 0; c <= Predictions::kColours; ++c) out.emplace_back(width, height, 0);
  parallel_for(0, out.size(), [&](std::size_t c) {
    for (std::size_t number = 0; number < parts.size(); ++number) {
      const Predictions& part = parts[number];
      if (part.edge == 0) continue;
      const Tile t = detail::tile_of(number, width, height);
      const int y0 = std::max(0, t.y - window), y1 = std::min(height, t.y + t.height + window);
      const int x0 = std::max(0, t.x - window), x1 = std::min(width, t.x + t.width + window);
      for (int y = y0; y < y1; ++y) {
        const float* from =
            part.sums[c].data() + std::ptrdiff_t(y - t.y + window) * part.edge - t.x + window;
        float* to = out[c].row(y);
        for (int x = x0; x < x1; ++x) to[x] += from[x];
      }
    }
  });
  return out;
}

/// One half's colour, with weights from the other half.
Planes filter_half(const Halves& halves, std::size_t half, const Planes& features,
                   const detail::PatchOptions& options, const std::function<bool()>& stop) {
  const int width = halves.filtered.width(), height = halves.filtered.height();
  const detail::RegressionInput in{halves.colour[1 - half], halves.colour[half].values, features,
                                   options};
  std::vector<Predictions> parts(detail::tiles_in(width, height));
  parallel_for(0, parts.size(), [&](std::size_t i) {
    detail::heed(stop);
    const Tile t = detail::tile_of(i, width, height);
    if (any_filtered(halves.filtered, t)) parts[i] = detail::regress(in, t);
  });
  Planes sums = join(parts, width, height, options.window);
  for (std::size_t c = 0; c < Predictions::kColours; ++c) {
    for (int y = 0; y < height; ++y) {
      const float* weights = sums[Predictions::kColours].row(y);
      float* to = sums[c].row(y);
      for (int x = 0; x < width; ++x) to[x] = weights[x] > 0 ? to[x] / weights[x] : 0;
    }
  }
  sums.pop_back();
  return sums;
}

/// Errors of one channel: of the mean of both filtered halves.
struct Errors {
  Plane variance, mse;  ///< smoothed
  double mean_mse = 0;  ///< over the pixels that were filtered
};

/// With e_a and e_b the errors of the filtered halves, ((e_a + e_b)/2)^2 =
/// (e_a^2 + e_b^2)/2 - ((e_a - e_b)/2)^2, of which the last term is seen, and e_a^2 is on average
/// (a - v)^2 less the variance of v, the other half as it was.
struct RawErrors {
  Plane halves;       ///< (e_a^2 + e_b^2)/2, on average
  Plane difference;   ///< ((e_a - e_b)/2)^2
  Plane uncertainty;  ///< variance of `halves`, were noise normal and the filter without error
};

RawErrors find_raw_errors(const Halves& halves, const std::array<Planes, 2>& filtered,
                          std::size_t c) {
  const int width = halves.filtered.width(), height = halves.filtered.height();
  RawErrors raw{{width, height, 0}, {width, height, 0}, {width, height, 0}};
  parallel_for(0, std::size_t(height), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x) {
      double sum = 0, uncertain = 0;
      for (const std::size_t half : {0u, 1u}) {
        const detail::Guide& other = halves.colour[1 - half];
        const double d = double(filtered[half][c].row(y)[x]) - double(other.values[c].row(y)[x]);
        const double noise = double(other.variances[c].row(y)[x]);
        sum += (d * d - noise) / 2, uncertain += noise * noise / 2;
      }
      const double d = double(filtered[0][c].row(y)[x]) - double(filtered[1][c].row(y)[x]);
      raw.halves.row(y)[x] = float(sum);
      raw.difference.row(y)[x] = float(d * d / 4);
      raw.uncertainty.row(y)[x] = float(uncertain);
    }
  });
  return raw;
}

/// What the halves' common error adds to the variance. Where that is less than its own uncertainty
/// little of it is believed: the positive part of noise would else look like an error everywhere.
double believed(double common, double uncertainty) {
  constexpr double kDeviations = 3;
  if (!(common > 0)) return 0;
  return common * (common * common / (common * common + kDeviations * kDeviations * uncertainty));
}

Errors find_errors(const Halves& halves, const std::array<Planes, 2>& filtered, std::size_t c) {
  constexpr int kSmooth = 9;
  constexpr double kArea = (2 * kSmooth + 1) * (2 * kSmooth + 1);
  const RawErrors raw = find_raw_errors(halves, filtered, c);
  Errors errors{detail::box_mean(raw.difference, halves.filtered, kSmooth),
                detail::box_mean(raw.halves, halves.filtered, kSmooth)};
  const Plane uncertainty = detail::box_mean(raw.uncertainty, halves.filtered, kSmooth);
  double sum = 0, least = 0, count = 0;
  for (int y = 0; y < halves.filtered.height(); ++y) {
    for (int x = 0; x < halves.filtered.width(); ++x) {
      if (!(halves.filtered.row(y)[x] > 0)) continue;
      const double difference = double(raw.difference.row(y)[x]);
      sum += double(raw.halves.row(y)[x]) - difference, least += difference, ++count;
      const double variance = double(errors.variance.row(y)[x]);
      const double common = double(errors.mse.row(y)[x]) - 2 * variance;
      errors.mse.row(y)[x] =
          float(variance + believed(common, double(uncertainty.row(y)[x]) / kArea));
    }
  }
  errors.mean_mse = std::max(sum, least) / count;
  return errors;
}

double luminance_of(Vec3d c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

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

/// The errors of the pixels that were left are added to those of all the others together, which
/// are known better than the parts.
double relative_error(const Denoised& d, const Halves& halves, Vec3d mean_mse) {
  const Plane& filtered = halves.filtered;
  double errors = 0, light = 0;
  for (std::size_t i = 0; i < d.colour.size(); ++i) {
    const auto width = std::size_t(filtered.width());
    const bool left = !(filtered.row(int(i / width))[i % width] > 0);
    errors += luminance_of(left ? d.mse[i] : mean_mse), light += luminance_of(d.colour[i]);
  }
  return light > 0 ? std::sqrt(errors * double(d.colour.size())) / light : 0;
}

Denoised filter(const Film& film, const DenoiseOptions& o) {
  Denoised out;
  for (const PixelSums& p : film.pixels) {
    out.colour.push_back(mean(p));
    out.variance.push_back(variance_of_mean(p));
  }
  out.mse = out.variance;
  const detail::PatchOptions patches{o.window, o.patch, float(o.bandwidth)};
  const int margin = detail::margin_of(patches);
  const Halves halves = detail::make_halves(film, margin);
  Vec3d mean_mse;
  if (halves.any) {
    const Planes features = detail::make_features(film, margin, o.stop);
    const std::array<Planes, 2> filtered{filter_half(halves, 0, features, patches, o.stop),
                                         filter_half(halves, 1, features, patches, o.stop)};
    for (int c = 0; c < 3; ++c) {
      const Errors errors = find_errors(halves, filtered, std::size_t(c));
      put(film, halves, filtered, c, errors, out);
      mean_mse[c] = errors.mean_mse * halves.scale * halves.scale;
    }
  }
  out.relative_error = relative_error(out, halves, mean_mse);
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
  add_layer(out, "noisy", "RGB", [](const PixelSums& p) { return mean(p); });
  add_layer(out, "noisy_variance", "XYZ", variance_of_mean);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    PixelSums& p = out.pixels[i];
    const double n = p.samples;
    p.sum = d.colour[i] * n;
    p.sum_squares = d.mse[i] * (n * (n - 1)) + p.sum * d.colour[i];
  }
  return out;
}

Denoised denoise(const Film& film, const DenoiseOptions& o) {
  check(o);
  detail::check_film(film);
  Denoised out;
  if (film.pixels.empty()) return out;
  const int threads = o.threads > 0 ? o.threads : tbb::this_task_arena::max_concurrency();
  constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
  const tbb::global_control allow(
      kLimit, std::max(std::size_t(threads), tbb::global_control::active_value(kLimit)));
  tbb::task_arena arena(threads);
  arena.execute([&] { out = filter(film, o); });
  return out;
}

}  // namespace pvol
