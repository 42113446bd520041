// The path tracer of embed_paths.h as a wavefront: thousands of paths side by side, whose flights
// are one batch, and whose shadow rays another. What lies between is plain loops over arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "embed_paths.h"
#include "pvol/pvol.h"
#include "pvol/volume/batch.h"

namespace pvol::bench {

/// Paths under way: the first n of each array.
struct Wave {
  static constexpr std::size_t kMost = 4096;
  std::size_t n = 0;
  double at[3][kMost], t[kMost];  ///< where they are, and how far they fly
  float to[3][kMost];             ///< unit vectors
  float weight[kMost], radiance[kMost], through[kMost];

  /// Another path takes the place of one that ended.
  void drop(std::size_t i) {
    --n;
    for (int axis = 0; axis < 3; ++axis) {
      at[axis][i] = at[axis][n], to[axis][i] = to[axis][n];
    }
    t[i] = t[n], weight[i] = weight[n], radiance[i] = radiance[n];
  }
};

/// 32 well-mixed bits, which compilers make vectors of.
[[nodiscard]] inline std::uint32_t mix32(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}
[[nodiscard]] inline float uniform_of(std::uint32_t bits) {
  return float(std::int32_t(bits >> 8)) * 0x1p-24f;
}

inline void start_path(const Setting& s, Wave& w, Rng::Pair pixel) {
  const Vec3d d = camera_direction(s, pixel);
  for (int axis = 0; axis < 3; ++axis) {
    w.at[axis][w.n] = s.eye[axis], w.to[axis][w.n] = float(d[axis]);
  }
  w.weight[w.n] = 1, w.radiance[w.n] = 0;
  ++w.n;
}

/// To where they collide; those that do not have seen the sky.
inline void move(const Setting& s, Wave& w, Mean& mean) {
  for (std::size_t i = 0; i < w.n;) {
    if (w.t[i] < std::numeric_limits<double>::infinity()) {
      ++i;
      continue;
    }
    mean.add(double(w.radiance[i] + w.weight[i] * s.sky));
    w.drop(i);
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < w.n; ++i) w.at[axis][i] += w.t[i] * double(w.to[axis][i]);
  }
}

/// What the sun adds, the roulette, and where paths turn to.
inline void scatter(const Setting& s, Wave& w, std::uint32_t seed) {
  const HenyeyGreenstein phase = s.phase;
  const Vec3f sun = s.sun;
  const float albedo = s.albedo, irradiance = s.irradiance;
  const std::uint32_t n = std::uint32_t(w.n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = mix32(seed + i * 0x9e3779b9u), b = mix32(a + 1), c = mix32(b + 1);
    const Vec3f from(w.to[0][i], w.to[1][i], w.to[2][i]);
    const float weight = w.weight[i] * albedo;
    w.radiance[i] += weight * irradiance * pdf_phase(phase, from, sun) * w.through[i];
    const float kept = uniform_of(a) < 0.5f ? 0.0f : 2 * weight;
    w.weight[i] = weight < 0.25f ? kept : weight;
    const Vec3f to = sample_phase(phase, from, uniform_of(b), uniform_of(c)).direction;
    w.to[0][i] = to.x, w.to[1][i] = to.y, w.to[2][i] = to.z;
  }
}

inline void end_lost(Wave& w, Mean& mean) {
  for (std::size_t i = 0; i < w.n;) {
    if (w.weight[i] > 0) {
      ++i;
      continue;
    }
    mean.add(double(w.radiance[i]));
    w.drop(i);
  }
}

/// Traces paths whose rays are batches: rays.fly(wave, sample) sets t, rays.pass(wave, sun, sample)
/// sets through. A sample's random numbers belong to the call.
template <class Rays>
void trace_waves(const Setting& s, const Rays& rays, const Round& round, Mean& mean) {
  const auto w = std::make_unique<Wave>();
  std::uint64_t sample = std::uint64_t(round.round) << 32;
  for (int started = 0; started < round.paths || w->n > 0; sample += 2) {
    for (; started < round.paths && w->n < Wave::kMost; ++started) {
      start_path(s, *w, round.camera(started));
    }
    rays.fly(*w, sample);
    move(s, *w, mean);
    rays.pass(*w, s.sun, sample + 1);
    scatter(s, *w, std::uint32_t(mix64(sample ^ std::uint64_t(round.number) << 56)));
    end_lost(*w, mean);
  }
}

/// By pvol/volume/batch.h.
struct BatchRays {
  const BatchField& field;
  Transmittance estimator;
  std::uint64_t seed;

  [[nodiscard]] static VectorArray origins(const Wave& w) {
    return {w.at, true, sizeof(double), sizeof(w.at[0])};
  }
  [[nodiscard]] BatchNumbers numbers(std::uint64_t sample) const {
    return {.seed = seed, .sample = sample};
  }
  void fly(Wave& w, std::uint64_t sample) const {
    const VectorArray to{w.to, false, sizeof(float), sizeof(w.to[0])};
    (void)sample_flights(field, {w.n, origins(w), to}, numbers(sample), w.t);
  }
  void pass(Wave& w, const Vec3f& sun, std::uint64_t sample) const {
    const RayBatch rays{w.n, origins(w), {&sun, false, 0, sizeof(float)}};
    (void)sample_transmittances(field, rays, numbers(sample), estimator, w.through);
  }
};

/// By pvol/pvol.h.
struct CapiBatchRays {
  const pvol_volume* volume;
  pvol_estimator estimator;
  std::uint64_t seed;

  [[nodiscard]] static pvol_vectors origins(const Wave& w) {
    return {w.at, sizeof(double), sizeof(w.at[0]), PVOL_DOUBLE, 0};
  }
  void fly(Wave& w, std::uint64_t sample) const {
    const pvol_vectors to{w.to, sizeof(float), sizeof(w.to[0]), PVOL_FLOAT, 0};
    const pvol_rays rays{w.n, origins(w), to, {}};
    const pvol_streams streams{seed, 0, sample, nullptr};
    (void)pvol_flights(volume, &rays, &streams, w.t);
  }
  void pass(Wave& w, const Vec3f& sun, std::uint64_t sample) const {
    const pvol_rays rays{w.n, origins(w), {&sun, 0, sizeof(float), PVOL_FLOAT, 0}, {}};
    const pvol_streams streams{seed, 0, sample, nullptr};
    (void)pvol_transmittances(volume, &rays, estimator, &streams, w.through);
  }
};

}  // namespace pvol::bench
