// A batch of samples from the camera to the film: which stage runs when.

#if defined(PVOL_LANE_TRACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_TRACE_INL_H
#undef PVOL_LANE_TRACE_INL_H
#else
#define PVOL_LANE_TRACE_INL_H
#endif

#include "render/engine/wavefront/camera-inl.h"
#include "render/engine/wavefront/scatter-inl.h"
#include "render/engine/wavefront/seen_lights-inl.h"
#include "render/engine/wavefront/wavefront.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

using WeightAt = Rgb (*)(const Records&, std::size_t);

/// What the flight of a record brings on its way, which has left, or has ended at its place, where
/// a fire brings `at_end`.
inline void add_line(const WavefrontScene& s, WavefrontMemory& m, const Records& q, std::size_t at,
                     bool left, Rgb at_end, Rgb weight) {
  if (s.setup.flights_bring_light()) add_on_the_way(s, m, q, at, left, at_end, weight);
  if (s.volume.asks_lamps) ask_lamps(s, m, q, at, left, weight);
}

/// Of flights that left, and of those to collisions from one on.
void add_lines_of_gone(const WavefrontScene& s, WavefrontMemory& m, WeightAt weight_at) {
  if (!s.along) return;
  for (std::size_t k = 0; k < m.events.gone; ++k) {
    const std::size_t at = m.events.gone_source[k];
    add_line(s, m, m.flying, at, true, Rgb(0.0f), weight_at(m.flying, at));
  }
}
void add_lines_of_collisions(const WavefrontScene& s, WavefrontMemory& m, std::size_t from,
                             WeightAt weight_at) {
  visit_ends(s, m, m.collisions, from, [&](std::size_t at, Rgb at_end) {
    if (!s.along && !(largest(at_end) > 0)) return;
    add_line(s, m, m.collisions, at, false, at_end, weight_at(m.collisions, at));
  });
}

/// A ray of the camera that met nothing sees what lies behind, dimmed by the weight.
inline void see_behind(const PathSetup& s, WavefrontMemory& m, std::uint32_t slot, Vec3f direction,
                       Rgb weight = Rgb(1.0f)) {
  if (s.weighs) m.slots.dim(slot, weight);
  if (!s.options.background) return;
  m.slots.add(slot, 0, [&](PathResult& r) {
    add_constant(s, weight, r);
    if (s.depths == nullptr) {
      add_seen(s, direction, weight, r);
    } else {
      add_light(s, s.light.sources.size(), weight * sky_part(s, direction, false), r);
    }
  });
}

/// A path that left brings the light of where it went, times a factor.
template <class ComponentKind>
HWY_INLINE void end_path(const WavefrontScene& s, WavefrontMemory& m, const Records& q,
                         std::size_t at, float factor = 1) {
  const std::uint32_t id = q.bits(kId)[at];
  m.slots.add(slot_of(id), number_of(id), [&](PathResult& r) {
    const auto pdf = [&] { return q[kPdf][at]; };
    add_scattered(s.setup, pdf, direction_at(q, at), weight_at<ComponentKind>(q, at) * factor, r);
  });
}

/// What a shadow ray that left brings from its light.
template <class ComponentKind>
[[nodiscard]] inline Rgb arrived_by(const WavefrontScene& s, const Records& q, std::size_t at) {
  const std::uint32_t light = light_of(q.bits(kId)[at]);
  const bool sky = light == s.setup.light.sources.size();
  const Rgb radiance = sky ? s.setup.light.sky.radiance(direction_at(q, at)) - s.setup.constant
                           : s.lights[light].radiance;
  const float passed = s.ratio && !s.setup.by_channel ? q[kPdf][at] : 1;
  return weight_at<ComponentKind>(q, at) * radiance * passed;
}
template <class ComponentKind>
HWY_INLINE void end_shadow_ray(const WavefrontScene& s, WavefrontMemory& m, const Records& q,
                               std::size_t at) {
  const std::uint32_t id = q.bits(kId)[at];
  m.slots.add(slot_of(id), scatterings_of(id), [&](PathResult& r) {
    add_light(s.setup, light_of(id), arrived_by<ComponentKind>(s, q, at), r);
  });
}

/// Rays of a slice that left.
template <class ComponentKind>
HWY_NOINLINE void end_camera_rays(const WavefrontScene& s, WavefrontMemory& m) {
  if (s.camera_lines) add_lines_of_gone(s, m, weight_at<ComponentKind>);
  for (std::size_t k = 0; k < m.events.gone; ++k) {
    const std::size_t at = m.events.gone_source[k];
    see_behind(s.setup, m, slot_of(m.flying.bits(kId)[at]), direction_at(m.flying, at),
               weight_at<ComponentKind>(m.flying, at));
  }
}
template <class ComponentKind>
HWY_NOINLINE void end_paths(const WavefrontScene& s, WavefrontMemory& m) {
  if (s.lines) add_lines_of_gone(s, m, weight_at<ComponentKind>);
  if (s.dark_sky) return;
  for (std::size_t k = 0; k < m.events.gone; ++k) {
    end_path<ComponentKind>(s, m, m.flying, m.events.gone_source[k]);
  }
}
template <class ComponentKind>
HWY_NOINLINE void end_shadow_rays(const WavefrontScene& s, WavefrontMemory& m) {
  for (std::size_t k = 0; k < m.events.gone; ++k) {
    end_shadow_ray<ComponentKind>(s, m, m.flying, m.events.gone_source[k]);
  }
}

/// Puts a ray at a place, in cells from the octree's origin, at or in the box of the support.
inline void put_ray(const WavefrontScene& s, Records& q, Vec3d place, Vec3f d, Rgb weight,
                    std::uint32_t id, Rng& rng) {
  const std::size_t n = put_ray(s.field, q, place, d, rng);
  for (int c = 0; c < 3; ++c) q[kW0 + std::size_t(c)][n] = weight[c];
  q[kPdf][n] = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) q[kFromX + axis][n] = q[kX + axis][n];
  q.bits(kId)[n] = id;
}

/// Puts a camera ray where it enters the box of the support; one that misses that sees what lies
/// behind.
inline void start(const WavefrontScene& s, WavefrontMemory& m, const CameraRays& all, std::size_t k,
                  ShellCounts& shells) {
  const auto slot = std::uint32_t(all.rays.ray[k]);
  const PixelSample& sample = all.sample[k];
  m.slots.note_pixel(slot, sample.x, sample.y);
  const Ray ray = all.rays.in_world(k), cells = all.rays.in_cells(k);
  if (s.setup.depths != nullptr) {
    see_lights({&s, 1}, m, slot, ray, 0, numbers_aside(s.setup, sample, Aside::lights));
  }
  const Span span{all.rays.t0[k], all.rays.t1[k]};
  const Vec3f d(ray.d);
  const bool misses = !(span.t0 < span.t1) || s.volume.volume.density.octree.empty() ||
                      outside_shell(s.volume, cells, span, shells);
  Rng rng = numbers_of(s.setup, sample);
  if (s.lines_outside) {
    m.slots.add(slot, 0, [&](PathResult& r) {
      const auto unscattered = [] { return 0.0f; };
      const FlightLine up_to_box{ray.o, d, misses ? kEndless : span.t0};
      detail::add_on_the_way(s.setup, up_to_box, unscattered, Rgb(1.0f), Along{{&s, 1}, rng}, r);
    });
  }
  if (misses) {
    see_behind(s.setup, m, slot, d);
    return;
  }
  put_ray(s, m.camera, cells.at(span.t0), d, Rgb(1.0f), slot, rng);
}

/// All that a first collision of a ray of the camera of this weight brings at once.
inline void add_first_collision(const PathSetup& s, WavefrontMemory& m, std::uint32_t slot,
                                const FirstCollision& first, Rgb weight) {
  m.slots.alpha[slot] = 1;
  if (largest(s.constant) > 0) {
    m.slots.add(slot, 0, [&](PathResult& r) { add_constant(s, weight, r); });
  }
  if (!s.first_collisions) return;
  m.slots.first[slot] = first;
  if (s.weighs) m.slots.note_first_weight(slot, weight);
}
template <class ComponentKind>
HWY_NOINLINE void add_first_collisions(const WavefrontScene& s, WavefrontMemory& m,
                                       std::size_t from) {
  for (std::size_t k = from; k < m.collisions.n; ++k) {
    const std::uint32_t slot = slot_of(m.collisions.bits(kId)[k]);
    FirstCollision first;
    if (s.setup.first_collisions) first.place = world_place(s, m.collisions, k);
    add_first_collision(s.setup, m, slot, first, weight_at<ComponentKind>(m.collisions, k));
  }
}

/// Most rays that fly at once. Those that are kept in the world are large, and caches are to hold
/// them from one stage to the next.
[[nodiscard]] inline std::size_t slice_of(const WavefrontScene& s) {
  return s.many ? kSlice / 4 : kSlice;
}

/// Takes rays from the end of a queue and flies them; null collisions go back to it.
template <bool kLimited = false>
HWY_INLINE void take_and_fly(const WavefrontScene& s, WavefrontMemory& m, Records& queue,
                             Tally& tally) {
  queue.take_last(slice_of(s), s.fields, m.flying);
  SampleCounts counts{s, m, tally};
  fly<kLimited>(s.field, m, counts);
}

template <class ComponentKind>
HWY_INLINE void fly_camera_rays(const WavefrontScene& s, WavefrontMemory& m) {
  take_and_fly(s, m, m.camera, m.counts.path);
  end_camera_rays<ComponentKind>(s, m);
  const std::size_t before = m.collisions.n;
  decide(s, m, m.camera, &m.collisions, m.counts.path);
  add_first_collisions<ComponentKind>(s, m, before);
  if (s.camera_lines) add_lines_of_collisions(s, m, before, weight_at<ComponentKind>);
}

template <class ComponentKind>
HWY_INLINE void fly_paths(const WavefrontScene& s, WavefrontMemory& m) {
  take_and_fly(s, m, m.paths, m.counts.path);
  end_paths<ComponentKind>(s, m);
  const std::size_t before = m.collisions.n;
  decide(s, m, m.paths, &m.collisions, m.counts.path);
  if (s.lines) add_lines_of_collisions(s, m, before, weight_at<ComponentKind>);
}

template <class ComponentKind>
HWY_INLINE void fly_shadow_rays(const WavefrontScene& s, WavefrontMemory& m) {
  if (s.limited) {
    take_and_fly<true>(s, m, m.shadows, m.counts.shadow);
  } else {
    take_and_fly(s, m, m.shadows, m.counts.shadow);
  }
  end_shadow_rays<ComponentKind>(s, m);
  if (s.ratio) {
    weigh(s, m, m.shadows, m.counts.shadow, [](std::uint32_t) {});
  } else {
    decide(s, m, m.shadows, nullptr, m.counts.shadow);
  }
}

template <class ComponentKind>
HWY_NOINLINE void fly_to_fires(const WavefrontScene& s, WavefrontMemory& m) {
  take_and_fly(s, m, m.to_fires, m.counts.shadow);
  for (std::size_t k = 0; k < m.events.gone; ++k) {
    end_fire_ray<ComponentKind>(s, m, m.flying, m.events.gone_source[k], true, Rgb(0.0f));
  }
  decide(s, m, m.to_fires, &m.fire_ends, m.counts.shadow);
  visit_ends(s, m, m.fire_ends, 0, [&](std::size_t at, Rgb at_end) {
    end_fire_ray<ComponentKind>(s, m, m.fire_ends, at, false, at_end);
  });
  m.fire_ends.n = 0;
}

/// Adds the samples of a pixel from a slot on; returns the next slot.
inline std::uint32_t add_pixel(const PathSetup& s, WavefrontMemory& m, int x, int y,
                               std::uint32_t slot, std::uint32_t end, Film& film) {
  const std::size_t pixel = film.index(x, y);
  const bool counts = s.count && !film.counts.empty();
  std::uint32_t& samples = film.pixels[pixel].samples;
  load_sums(film, pixel, m.sums);
  for (; samples < end; ++samples, ++slot) {
    const PathResult& r = m.slots.result(slot);
    require_finite(r, film.x + x, film.y + y);
    add_aside(s, r, pixel, m.sums, film);
    const bool in_group = is_in_group(s, film.first_sample + samples);
    film.pixels[pixel].group_samples += std::uint32_t(in_group);
    m.rows.add(r, in_group);
    if (m.rows.n == PixelRows::kMost) add_rows(m.rows, m.sums);
    for (std::size_t c = 0; c < kPixelCounts.size() && counts; ++c) {
      film.counts[pixel][c] += m.slots.counts[slot][c];
    }
  }
  add_rows(m.rows, m.sums);
  store_sums(m.sums, pixel, film);
  return slot;
}

/// Adds a tile's samples to the film, which changes what they lack.
HWY_NOINLINE void finish(const PathSetup& s, WavefrontMemory& m, const ImagePart& tile,
                         const SampleTargets& targets, Film& film) {
  std::uint32_t slot = 0;
  m.rows.n = m.rows.n_of_group = 0;
  for (int y = tile.y; y != tile.y + tile.height; ++y) {
    for (int x = tile.x; x != tile.x + tile.width; ++x) {
      slot = add_pixel(s, m, x, y, slot, targets.of(film.index(x, y)), film);
    }
  }
}

/// Traces and adds a tile's samples through one volume; see WavefrontKernel.
template <bool kGuided, class ComponentKind>
bool trace(std::span<const WavefrontScene> scenes, WavefrontMemory& m, const ImagePart& tile,
           const SampleTargets& targets, Film& film, Counts& counts) {
  const WavefrontScene& s = scenes.front();
  Samples samples(tile, targets, film);
  m.slots.start(count_samples(tile, targets, film));
  m.counts = {};
  m.camera.n = m.paths.n = m.shadows.n = m.collisions.n = m.straight.n = m.turned.n = 0;
  m.to_fires.n = m.fire_ends.n = 0;
  ShellCounts shells;
  CameraRays& starting = m.starting;
  starting.clear();
  const auto any = [&] { return starting.any() || samples.any(); };
  for (;;) {
    if (s.setup.stop->load(std::memory_order_relaxed)) return false;
    if (m.paths.n >= kSlice) {
      fly_paths<ComponentKind>(s, m);
    } else if (m.shadows.n >= kSlice) {
      fly_shadow_rays<ComponentKind>(s, m);
    } else if (m.to_fires.n >= kSlice) {
      fly_to_fires<ComponentKind>(s, m);
    } else if (any() || m.camera.n > 0) {
      m.camera.reserve(kSlice);
      while (m.camera.n < kSlice && any()) {
        if (!starting.any()) {
          take_samples(s.setup, samples, starting);
          find_spans(s.volume.volume.density, starting.rays);
        }
        start(s, m, starting, starting.next++, shells);
      }
      fly_camera_rays<ComponentKind>(s, m);
    } else if (m.paths.n > 0) {
      fly_paths<ComponentKind>(s, m);
    } else if (m.shadows.n > 0) {
      fly_shadow_rays<ComponentKind>(s, m);
    } else if (m.to_fires.n > 0) {
      fly_to_fires<ComponentKind>(s, m);
    } else {
      break;
    }
    collide<kGuided, ComponentKind>(s, m);
    scatter<ComponentKind>(s, m.straight, m.paths);
    if constexpr (kGuided) scatter_guided<ComponentKind>(s, m.turned, m.paths);
  }
  finish(s.setup, m, tile, targets, film);
  m.counts.shell_tests = shells.tests;
  m.counts.shell_rejections = shells.rejections;
  if (s.setup.count) counts += m.counts;
  return true;
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
