#include "render/denoise/denoise_inputs.h"

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "pvol/math/parallel.h"
#include "pvol/render/aov.h"
#include "pvol/render/denoise.h"

namespace pvol {

AovSet denoising_aovs() {
  return {Aov::variance, Aov::samples, Aov::halves, Aov::depth, Aov::normal, Aov::albedo};
}

}  // namespace pvol

namespace pvol::detail {
namespace {

/// Pixels to each side over which the variance of colour and alpha is averaged. Where none of them
/// has a sample that collided, a pixel is taken for one of the background.
constexpr int kNoiseRadius = 2;

/// The same for features of first collisions.
constexpr int kFeatureRadius = 3;

const Layer* find_layer(const Film& film, const std::string& name) {
  const auto at = std::ranges::find(film.layers, name, &Layer::name);
  return at == film.layers.end() ? nullptr : &*at;
}

const Layer& layer_of(const Film& film, const std::string& name, Aov aov) {
  if (const Layer* layer = find_layer(film, name)) return *layer;
  throw Error("the film cannot be filtered: it lacks the layer " + name +
              "; render it with --aov " + row(aov).name);
}

const Layer& half_of(const Film& film, int half) {
  return layer_of(film, kHalfLayers[std::size_t(half)], Aov::halves);
}

/// Samples of a half; files do not say.
double samples_of(const Layer& half, const Film& film, std::size_t pixel) {
  return half.weights.empty() ? film.pixels[pixel].samples / 2.0 : half.weights[pixel];
}

/// Calls f(pixel, x, y) for all pixels, row by row in parallel.
template <class F>
void for_pixels(const Film& film, const F& f) {
  parallel_for(0, std::size_t(film.crop_height), [&](std::size_t y) {
    for (int x = 0; x < film.crop_width; ++x) f(film.index(x, int(y)), x, int(y));
  });
}

Plane make_plane(const Film& film, int margin) {
  return {film.crop_width, film.crop_height, margin};
}

template <class F>
Plane make_plane(const Film& film, int margin, const F& f) {
  Plane plane = make_plane(film, margin);
  for_pixels(film, [&](std::size_t i, int x, int y) { plane.row(y)[x] = float(f(i)); });
  plane.repeat_edges();
  return plane;
}

Plane ones(const Film& film) {
  return make_plane(film, 0, [](std::size_t) { return 1; });
}

/// A copy with this margin.
Plane with_margin(const Plane& from, int margin) {
  Plane to(from.width(), from.height(), margin);
  for (int y = 0; y < from.height(); ++y) std::copy_n(from.row(y), from.width(), to.row(y));
  to.repeat_edges();
  return to;
}

double mean_radiance(const Film& film) {
  double sum = 0;
  for (const PixelSums& p : film.pixels) {
    const Vec3d m = mean(p);
    sum += std::abs(m.x) + std::abs(m.y) + std::abs(m.z);
  }
  return sum / (3 * double(film.pixels.size()));
}

double share_hit(const PixelSums& p) { return std::clamp(p.alpha / p.samples, 0.0, 1.0); }

/// Both halves of the colour, and the variance of its pixels.
TwoHalves colours_of(const Film& film, double scale, int margin) {
  TwoHalves p;
  for (int c = 0; c < 3; ++c) {
    for (const int half : {0, 1}) {
      const Layer& layer = half_of(film, half);
      p.values[std::size_t(half)].push_back(make_plane(
          film, margin, [&](std::size_t i) { return value(layer, film, i)[c] / scale; }));
    }
    p.variances.push_back(make_plane(film, 0, [&](std::size_t i) {
      return variance_of_mean(film.pixels[i])[c] / (scale * scale);
    }));
  }
  return p;
}

/// The variance of a half's mean: that of all samples, of which it has a part. Variances of few
/// samples are noise themselves, low where bright samples were missed; so they are means over a
/// neighbourhood, without fireflies.
Plane variance_of_half(const Film& film, const Layer& half, const Plane& of_mean,
                       const Plane& others, int margin) {
  Plane raw = make_plane(film, 0);
  for_pixels(film, [&](std::size_t i, int x, int y) {
    const double part = film.pixels[i].samples / samples_of(half, film, i);
    raw.row(y)[x] = float(double(of_mean.row(y)[x]) * part);
  });
  return with_margin(box_mean(raw, others, kNoiseRadius), margin);
}

// --- features -----------------------------------------------------------------------------------

/// Planes that are filtered together, and what each pixel's value weighs: its samples.
struct Feature {
  Guide guide;
  Plane weight;
  std::vector<FeatureScale> scales;  ///< by the numbers of planes in the guide
};

/// Squared differences from the mean of four neighbours have 5/4 of the variance where the feature
/// is even; per unit of weight they are means over a neighbourhood. Detail counts as noise, and is
/// then smoothed where the colour does not tell it.
/// Where there is no value it is that of one sample.
Plane noise_of_feature(const Film& film, const Plane& value, const Plane& weight, int margin) {
  constexpr std::array<std::array<int, 2>, 4> kNext{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  Plane squares = make_plane(film, 0), counts = make_plane(film, 0);
  for_pixels(film, [&](std::size_t, int x, int y) {
    double sum = 0, inverse = 0;
    int found = 0;
    for (const auto& n : kNext) {
      const int px = std::clamp(x + n[0], 0, film.crop_width - 1);
      const int py = std::clamp(y + n[1], 0, film.crop_height - 1);
      const double w = double(weight.row(py)[px]);
      if (!(w > 0) || (px == x && py == y)) continue;
      sum += double(value.row(py)[px]), inverse += 1 / w, ++found;
    }
    const double own = double(weight.row(y)[x]);
    if (!(own > 0) || found == 0) return;
    const double d = double(value.row(y)[x]) - sum / found;
    squares.row(y)[x] = float(d * d / (1 / own + inverse / (found * found)));
    counts.row(y)[x] = 1;
  });
  const Plane of_one = box_mean(squares, counts, kFeatureRadius);
  Plane variance = make_plane(film, margin);
  for_pixels(film, [&](std::size_t, int x, int y) {
    const float w = weight.row(y)[x];
    variance.row(y)[x] = w > 0 ? of_one.row(y)[x] / w : of_one.row(y)[x];
  });
  variance.repeat_edges();
  return variance;
}

/// Pixels without a value get that of those around them: they would else be like none but each
/// other, and tell pixels in which by chance nothing collided from all others.
void fill(const Film& film, const Plane& weight, Plane& value) {
  const Plane around = box_mean(value, weight, kFeatureRadius);
  for_pixels(film, [&](std::size_t, int x, int y) {
    if (!(weight.row(y)[x] > 0)) value.row(y)[x] = around.row(y)[x];
  });
  value.repeat_edges();
}

/// A layer of first collisions. In units of its spread over the pixels that have any, which is 0
/// for one that is the same everywhere.
Feature feature_of(const Film& film, const Layer& layer, FeatureKind kind, int margin) {
  Feature f;
  f.weight = make_plane(film, margin, [&](std::size_t i) {
    return value(layer, film, i).x < kNothingMet ? film.pixels[i].alpha : 0;
  });
  const int components = int(layer.components.size());
  for (int c = 0; c < components; ++c) {
    double sum = 0, squares = 0, all = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const double w = value(layer, film, i).x < kNothingMet ? film.pixels[i].alpha : 0;
      const double v = value(layer, film, i)[c];
      if (w > 0) sum += w * v, squares += w * v * v, all += w;
    }
    if (!(all > 0)) continue;
    const double centre = sum / all, spread = squares / all - centre * centre;
    constexpr double kSame = 1e-10;  // of variances: what rounding leaves
    FeatureScale& scale = f.scales.emplace_back(FeatureScale{kind, c, centre});
    if (!(spread > kSame * squares / all)) continue;
    scale.spread = std::sqrt(spread), scale.plane = f.guide.values.size();
    f.guide.values.push_back(make_plane(film, margin, [&](std::size_t i) {
      const double v = value(layer, film, i)[c];
      return v < kNothingMet ? (v - centre) / scale.spread : 0;
    }));
    f.guide.variances.push_back(noise_of_feature(film, f.guide.values.back(), f.weight, margin));
    fill(film, f.weight, f.guide.values.back());
  }
  return f;
}

/// Alpha counts the samples that collide: its variance is a(1 - a)/n.
Feature alpha_of(const Film& film, int margin) {
  Feature f;
  f.weight = make_plane(film, margin, [](std::size_t) { return 1; });
  f.guide.values.push_back(
      make_plane(film, margin, [&](std::size_t i) { return share_hit(film.pixels[i]); }));
  const Plane raw = make_plane(film, 0, [&](std::size_t i) {
    const double a = share_hit(film.pixels[i]);
    return a * (1 - a) / film.pixels[i].samples;
  });
  f.guide.variances.push_back(with_margin(box_mean(raw, f.weight, kNoiseRadius), margin));
  f.scales.push_back({.kind = FeatureKind::alpha, .plane = 0});
  return f;
}

/// The sums of one row of a tile: weights times values of each plane, and weights.
struct RowSums {
  std::array<std::array<float, kTile>, 3> values{};
  std::array<float, kTile> weights{};
};

RowSums sum_row(const Feature& f, const Tile& t, const PatchWeights& weights, int window, int y) {
  RowSums sums;
  for (int dy = -window; dy <= window; ++dy) {
    for (int dx = -window; dx <= window; ++dx) {
      const float* alike = weights.row(dx, dy, y);
      const float* samples = f.weight.row(t.y + y + dy) + t.x + dx;
      std::array<float, kTile> w{};
      for (std::size_t x = 0; x < std::size_t(t.width); ++x) w[x] = alike[x] * samples[x];
      for (std::size_t x = 0; x < kTile; ++x) sums.weights[x] += w[x];
      for (std::size_t c = 0; c < f.guide.values.size(); ++c) {
        const float* v = f.guide.values[c].row(t.y + y + dy) + t.x + dx;
        for (std::size_t x = 0; x < std::size_t(t.width); ++x) sums.values[c][x] += w[x] * v[x];
      }
    }
  }
  return sums;
}

/// Non-local means of the feature, guided by itself. Pixels without it take what is around them.
void add_filtered(const Film& film, const Feature& f, int margin, const PatchOptions& options,
                  const std::function<bool()>& stop, Features& all) {
  Planes& to = all.planes;
  const std::size_t first = to.size();
  for (FeatureScale scale : f.scales) {
    if (scale.plane) *scale.plane += first;
    all.scales.push_back(scale);
  }
  if (f.guide.values.empty()) return;
  for (std::size_t c = 0; c < f.guide.values.size(); ++c) to.push_back(make_plane(film, margin));
  parallel_for(0, tiles_in(film.crop_width, film.crop_height), [&](std::size_t number) {
    heed(stop);
    const Tile t = tile_of(number, film.crop_width, film.crop_height);
    const PatchWeights weights(f.guide, f.guide, nullptr, t, options);
    for (int y = 0; y < t.height; ++y) {
      const RowSums sums = sum_row(f, t, weights, options.window, y);
      for (std::size_t c = 0; c < f.guide.values.size(); ++c) {
        const float* own = f.guide.values[c].row(t.y + y) + t.x;
        float* out = to[first + c].row(t.y + y) + t.x;
        for (std::size_t x = 0; x < std::size_t(t.width); ++x) {
          out[x] = sums.weights[x] > 0 ? sums.values[c][x] / sums.weights[x] : own[x];
        }
      }
    }
  });
  for (std::size_t c = first; c < to.size(); ++c) to[c].repeat_edges();
}

/// 1 for pixels around which there is noise, and samples collided.
Plane find_filtered(const Film& film, const Planes& variances, int margin) {
  const auto alpha = [&](std::size_t i) { return film.pixels[i].alpha; };
  const Plane hit = box_mean(make_plane(film, 0, alpha), ones(film), kNoiseRadius);
  Planes noise;
  for (const Plane& v : variances) noise.push_back(box_mean(v, ones(film), kNoiseRadius));
  Plane filtered = make_plane(film, margin);
  for_pixels(film, [&](std::size_t, int x, int y) {
    const bool noisy = std::ranges::any_of(noise, [&](const Plane& v) { return v.row(y)[x] > 0; });
    filtered.row(y)[x] = noisy && hit.row(y)[x] > 0 ? 1 : 0;
  });
  return filtered;
}

}  // namespace

void check_film(const Film& film) {
  for (const int half : {0, 1}) (void)half_of(film, half);
  (void)layer_of(film, "depth", Aov::depth);
  (void)layer_of(film, "normal", Aov::normal);
  (void)layer_of(film, "albedo", Aov::albedo);
  for (const PixelSums& p : film.pixels) {
    if (p.samples < 2) {
      throw Error(
          "the film cannot be filtered: a pixel has fewer than two samples, so its noise is "
          "unknown. If the file has no variances, render it again with --aov variance,samples");
    }
    if (!is_finite(p.sum) || !is_finite(p.sum_squares)) {
      throw Error("the film cannot be filtered: a pixel is not finite; render it again");
    }
  }
}

Halves make_halves(const Film& film, int margin) {
  Halves h;
  const double radiance = mean_radiance(film);
  h.scale = radiance > 0 ? radiance : 1;
  TwoHalves p = colours_of(film, h.scale, margin);
  h.filtered = find_filtered(film, p.variances, margin);
  h.fireflies = spread_fireflies(p, h.filtered);
  for (const int half : {0, 1}) {
    Guide& guide = h.colour[std::size_t(half)];
    guide.values = std::move(p.values[std::size_t(half)]);
    for (Plane& plane : guide.values) plane.repeat_edges();
    for (const Plane& v : p.variances) {
      guide.variances.push_back(
          variance_of_half(film, half_of(film, half), v, h.fireflies.others, margin));
    }
  }
  for (int y = 0; y < film.crop_height; ++y) {
    const float* r = h.filtered.row(y);
    h.any = h.any || std::any_of(r, r + film.crop_width, [](float f) { return f > 0; });
  }
  return h;
}

void heed(const std::function<bool()>& stop) {
  if (stop && stop()) throw Error("denoise: interrupted");
}

namespace {
constexpr PatchOptions kFeatures{.window = 5, .patch = 3, .bandwidth = 1};
}

std::optional<Features> make_velocity(const Film& film, int margin,
                                      const std::function<bool()>& stop) {
  const Layer* layer = find_layer(film, row(Aov::velocity).name);
  if (layer == nullptr) return {};
  const int own = std::max(margin, margin_of(kFeatures));
  Features f;
  add_filtered(film, feature_of(film, *layer, FeatureKind::velocity, own), margin, kFeatures, stop,
               f);
  return f;
}

Features make_features(const Film& film, int margin, const std::function<bool()>& stop) {
  Features all;
  for (const int axis : {0, 1}) {
    constexpr float kScale = 0.1f;
    Plane& place = all.planes.emplace_back(make_plane(film, margin));
    for (int y = -margin; y < film.crop_height + margin; ++y) {
      for (int x = -margin; x < film.crop_width + margin; ++x) {
        place.row(y)[x] = kScale * float(axis == 0 ? x : y);
      }
    }
  }
  const int own = std::max(margin, margin_of(kFeatures));
  const auto add = [&](const Feature& f) { add_filtered(film, f, margin, kFeatures, stop, all); };
  add(alpha_of(film, own));
  add(feature_of(film, layer_of(film, "depth", Aov::depth), FeatureKind::depth, own));
  add(feature_of(film, layer_of(film, "normal", Aov::normal), FeatureKind::normal, own));
  add(feature_of(film, layer_of(film, "albedo", Aov::albedo), FeatureKind::albedo, own));
  return all;
}

}  // namespace pvol::detail
