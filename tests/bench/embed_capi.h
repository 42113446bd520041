// A volume of the C API (pvol/pvol.h) of a grid's samples, and the media that ask it ray by ray.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "embed_media.h"
#include "pvol/pvol.h"

namespace pvol::bench {

struct Release {
  void operator()(pvol_volume* v) const { pvol_release(v); }
};
using CapiVolume = std::unique_ptr<pvol_volume, Release>;

/// Throws std::runtime_error.
[[nodiscard]] inline CapiVolume make_capi_volume(const VoxelGrid& grid, double extinction) {
  std::vector<pvol_leaf> leaves;
  for (const Brick& b : grid.bricks) {
    leaves.push_back({b.values, {b.origin.x, b.origin.y, b.origin.z}});
  }
  std::vector<pvol_tile> tiles;
  for (const Tile& t : grid.tiles) {
    tiles.push_back({{t.origin.x, t.origin.y, t.origin.z}, t.edge, t.value});
  }
  double map[12];
  for (int row = 0; row < 3; ++row) {
    const Vec3d& m = grid.index_to_world.m[std::size_t(row)];
    const double values[] = {m.x, m.y, m.z, grid.index_to_world.t[row]};
    std::copy(values, values + 4, map + 4 * row);
  }
  pvol_leaves all{};
  all.leaves = leaves.data(), all.leaf_count = leaves.size();
  all.tiles = tiles.data(), all.tile_count = tiles.size();
  CapiVolume v(pvol_new_volume());
  if (!v || pvol_set_leaves(v.get(), PVOL_DENSITY, &all) != PVOL_OK ||
      pvol_set_transform(v.get(), PVOL_DENSITY, map) != PVOL_OK ||
      pvol_set_extinction(v.get(), extinction) != PVOL_OK ||
      pvol_commit(v.get(), nullptr) != PVOL_OK) {
    throw std::runtime_error(v ? pvol_message(v.get()) : "no memory");
  }
  return v;
}

[[nodiscard]] inline pvol_ray capi_ray(const Ray& r) {
  return {{r.o.x, r.o.y, r.o.z}, {r.d.x, r.d.y, r.d.z}, std::numeric_limits<double>::infinity()};
}

/// f(random) with the numbers of an Rng, which is used on.
template <class F>
auto with_capi_numbers(Rng& rng, const F& f) {
  const Rng::State s = rng.state();
  pvol_random random{};
  random.key[0] = s.key, random.key[1] = s.sample, random.used = s.counter;
  const auto result = f(&random);
  rng = Rng(Rng::State{s.key, s.sample, random.used});
  return result;
}

/// A pvol_walk as visit_tentative has segments.
struct CapiSegments {
  pvol_walk walk;

  [[nodiscard]] std::optional<Segment> next() {
    pvol_segment s;
    if (pvol_next(&walk, &s) != 1) return std::nullopt;
    return Segment{s.t0, s.t1, s.lo, s.hi, {}};
  }
};

/// pvol_enter, pvol_next, and look-ups at t of a segment.
template <bool kAnalog>
struct CapiSegmentsMedium {
  const pvol_volume* volume;

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count& count) const {
    CapiSegments segments;
    const pvol_ray r = capi_ray(ray);
    if (pvol_enter(volume, &r, &segments.walk) != 1) return std::numeric_limits<double>::infinity();
    return fly(segments, rng, count, [&](const Segment&, double t, float mu) {
      return pvol_walk_exceeds(&segments.walk, t, mu) == 1;
    });
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count& count) const {
    if constexpr (kAnalog) return std::isfinite(flight(ray, rng, count)) ? 0.0f : 1.0f;
    CapiSegments segments;
    const pvol_ray r = capi_ray(ray);
    if (pvol_enter(volume, &r, &segments.walk) != 1) return 1;
    return pass(segments, rng, count,
                [&](const Segment&, double t) { return pvol_walk_extinction(&segments.walk, t); });
  }
};

/// One call a ray.
template <bool kAnalog>
struct CapiCalls {
  static constexpr pvol_estimator kEstimator = kAnalog ? PVOL_ANALOG : PVOL_RATIO;
  const pvol_volume* volume;

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count&) const {
    double t = 0;
    const pvol_ray r = capi_ray(ray);
    const bool collided = with_capi_numbers(
        rng, [&](pvol_random* random) { return pvol_sample_flight(volume, &r, random, &t) == 1; });
    return collided ? t : std::numeric_limits<double>::infinity();
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count&) const {
    const pvol_ray r = capi_ray(ray);
    return with_capi_numbers(rng, [&](pvol_random* random) {
      float passed = 1;
      (void)pvol_sample_transmittance(volume, &r, kEstimator, random, &passed);
      return passed;
    });
  }
};

/// The same along walks that go on where they collided.
template <bool kAnalog>
struct CapiWalks {
  const pvol_volume* volume;
  pvol_walk walk{};
  bool entered = false;
  double t = 0;  ///< of the last collision

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count&) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const pvol_ray r = capi_ray(ray);
    const int on = entered ? pvol_resume(&walk, t, r.d, kFar) : pvol_enter(volume, &r, &walk);
    if (on != 1) return kFar;
    entered = with_capi_numbers(
        rng, [&](pvol_random* random) { return pvol_walk_flight(&walk, random, &t) == 1; });
    return entered ? t : kFar;
  }
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count&) const {
    const pvol_ray r = capi_ray(ray);
    pvol_walk shadow = walk;
    (void)pvol_resume(&shadow, t, r.d, r.t_max);
    return with_capi_numbers(rng, [&](pvol_random* random) {
      return pvol_walk_transmittance(&shadow, CapiCalls<kAnalog>::kEstimator, random);
    });
  }
};

}  // namespace pvol::bench
