// Rays from collisions to lights (THEORY.md, T5.2, T5.19).

#if defined(PVOL_LANE_LIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_LIGHTS_INL_H
#undef PVOL_LANE_LIGHTS_INL_H
#else
#define PVOL_LANE_LIGHTS_INL_H
#endif

#include "render/engine/wavefront/lamps-inl.h"
#include "render/engine/wavefront/sky-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A direction to a light in each lane, as LightSample.
struct Towards {
  V direction;
  V radiance;
  F pdf, distance;
  F factor;  ///< of what a ray that arrives brings: the light's own radiance times it
};

/// Random numbers for what is asked for lane by lane.
struct LaneStreams {
  alignas(64) std::uint32_t key[kLanes], counter[kLanes];

  HWY_INLINE explicit LaneStreams(Random& rng) {
    store(rng.next(), key), store(rng.next(), counter);
  }
  [[nodiscard]] Rng of(std::size_t lane, std::uint64_t stream) const {
    return {key[lane], counter[lane], stream};
  }
};

/// The same in memory; nothing comes in lanes that are not set.
struct TowardsByLane {
  alignas(64) float d[3][kLanes] = {}, radiance[3][kLanes] = {};
  alignas(64) float pdf[kLanes] = {}, distance[kLanes] = {}, factor[kLanes] = {};

  void set(std::size_t lane, const LightSample& l, Rgb brought, float factor_) {
    for (int c = 0; c < 3; ++c) d[c][lane] = l.direction[c], radiance[c][lane] = brought[c];
    pdf[lane] = l.pdf, factor[lane] = factor_;
    distance[lane] = float(std::min(l.distance, 0x1p100));
  }
  HWY_INLINE Towards in_lanes() const {
    const auto vector = [](const float(*v)[kLanes]) -> V {
      return {load(v[0]), load(v[1]), load(v[2])};
    };
    return {vector(d), vector(radiance), load(pdf), load(distance), load(factor)};
  }
};

/// Samples the picture of a sky.
HWY_NOINLINE Towards sample_sky(const WavefrontScene& s, Random& rng) {
  const PictureSample l = sample_picture(s.setup.light.sky.picture()->tables(), rng);
  const Rgb constant = s.setup.constant;
  const V radiance{l.radiance.x - splat(constant.x), l.radiance.y - splat(constant.y),
                   l.radiance.z - splat(constant.z)};
  return {l.direction, radiance, l.pdf, splat(0x1p100f), splat(1)};
}

/// The places of paths in the world, lane by lane.
struct LanePlaces {
  const WavefrontScene& s;
  WorldRays& rays;
  alignas(64) float at[3][kLanes], times[kLanes];
  alignas(64) std::uint32_t ray[kLanes];

  template <class ComponentKind>
  LanePlaces(const WavefrontScene& scene, WavefrontMemory& m, const Paths<ComponentKind>& p)
      : s(scene), rays(m.rays) {
    store(p.x, at[0]), store(p.y, at[1]), store(p.z, at[2]), store(p.ray, ray);
    store(p.time, times);
    if (s.many) rays.prefetch(ray, count(p.alive));
  }
  [[nodiscard]] Vec3d in_cells(std::size_t lane) const {
    const Vec3d place{double(at[0][lane]), double(at[1][lane]), double(at[2][lane])};
    return place - Vec3d(DenseBounds::kBorder);
  }
  [[nodiscard]] Vec3d operator()(std::size_t lane) const {
    if (s.many && is_within(ray[lane])) {
      return s.setup.free_radii.of(instance_within(ray[lane])).to_world.point(in_cells(lane));
    }
    if (s.many) return rays[ray[lane]].place;
    return s.volume.cells_to_world.point(in_cells(lane));
  }
  /// Of the path, in frames.
  [[nodiscard]] float time(std::size_t lane) const {
    if (s.many && is_within(ray[lane])) return times[lane];
    return s.many ? rays[ray[lane]].time : 0;
  }
  /// Whether the flight to there brings what the place emits, of rays in the world.
  [[nodiscard]] bool brings_light(std::size_t lane) const {
    if (is_within(ray[lane])) return true;  // no surface comes before it
    const WorldRay& r = rays[ray[lane]];
    return r.nearest < r.among.direct_until;
  }
};

/// Asks one of the scene's lights, of any kind, from a lane; `times` is a factor on what it brings.
inline void ask_light(const WavefrontScene& s, std::size_t light, Vec3d place, float times,
                      std::size_t lane, Rng& rng, TowardsByLane& to) {
  const LightSample l = detail::sample_light(s.setup.light.sources[light], place, rng);
  const float all = largest(s.lights[light].radiance);
  to.set(lane, l, l.radiance * times, all > 0 ? times * (largest(l.radiance) / all) : 0);
}

/// A light that has no lanes of its own.
template <class ComponentKind>
HWY_NOINLINE Towards sample_other(const WavefrontScene& s, WavefrontMemory& m, std::size_t light,
                                  const Paths<ComponentKind>& p, Random& rng) {
  const LaneStreams streams(rng);
  const LanePlaces place(s, m, p);
  TowardsByLane to;
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    Rng own = streams.of(k, light);
    ask_light(s, light, place(k), 1, k, own, to);
  }
  return to.in_lanes();
}

/// A point light: nothing comes from one that is nearer than floats can tell, as in PointSource.
template <class ComponentKind>
HWY_INLINE Towards sample_point(const WavefrontScene& s, const SimdLight& l,
                                const Paths<ComponentKind>& p) {
  const V way{splat(l.place.x) - p.x, splat(l.place.y) - p.y, splat(l.place.z) - p.z};
  const auto along = [&](int axis) { return dot(splat(s.to_world[std::size_t(axis)]), way); };
  const V in_world{along(0), along(1), along(2)};
  const F squared = dot(in_world, in_world), distance = hn::Sqrt(squared);
  const F inverse = splat(1) / distance, factor = splat(1) / squared;
  const M far = hn::Lt(factor * splat(l.value), splat(0x1p120f));  // and not a NaN
  const F zero = splat(0);
  const auto at_hand = [&](F v, float otherwise) { return select(far, v, splat(otherwise)); };
  return {{at_hand(in_world.x * inverse, 0), at_hand(in_world.y * inverse, 0),
           at_hand(in_world.z * inverse, 1)},
          {splat(l.radiance.x) * at_hand(factor, 0), splat(l.radiance.y) * at_hand(factor, 0),
           splat(l.radiance.z) * at_hand(factor, 0)},
          zero,
          at_hand(distance, 0),
          at_hand(factor, 0)};
}

template <class ComponentKind>
HWY_INLINE Towards sample_light(const WavefrontScene& s, WavefrontMemory& m, std::size_t light,
                                const Paths<ComponentKind>& p, Random& rng) {
  const SimdLight& l = s.lights[light];
  const F far = splat(0x1p100f);
  if (l.kind == SimdLight::Kind::delta) {
    return {splat(l.direction), splat(l.radiance), splat(0), far, splat(1)};
  }
  if (l.kind == SimdLight::Kind::disc) {
    const F u = rng.uniform(), azimuth = rng.uniform();
    return {turn(splat(l.direction), splat(l.one_minus_cos_radius) * u, azimuth), splat(l.radiance),
            splat(l.pdf), far, splat(1)};
  }
  if (l.kind == SimdLight::Kind::point) return sample_point(s, l, p);
  if (l.kind == SimdLight::Kind::other) return sample_other(s, m, light, p, rng);
  return sample_sky(s, rng);
}

/// Shadow rays to lights, as `shadowed` draws them; `importance` is that of a ray there.
template <class ComponentKind>
HWY_INLINE void add_shadow_rays(const WavefrontScene& s, WavefrontMemory& m, const Towards& to,
                                U light, F importance, Paths<ComponentKind>& p) {
  const F pdf = ComponentKind(s, p.component).pdf(p.from, to.direction);
  const F share = select(hn::Gt(to.pdf, splat(0)), pdf / (to.pdf + pdf), pdf);
  const auto part = [&](float coefficient, std::size_t c, F radiance) {
    return splat(coefficient) * hn::Abs(p.w[ComponentKind::kWeights == 1 ? 0 : c] * radiance);
  };
  const F luminance = part(0.2126f, 0, to.radiance.x) + part(0.7152f, 1, to.radiance.y) +
                      part(0.0722f, 2, to.radiance.z);
  // Bright pixels do not go without them (THEORY.md, T5.2).
  const F value = luminance * share * importance * hn::Max(p.pixel, splat(1)) *
                  splat(1 / s.setup.light.shadow_unit);
  const M positive = hn::And(p.alive, hn::Gt(value, splat(0)));
  const M few = hn::And(positive, hn::Lt(value, splat(1)));
  const M chosen = hn::And(few, hn::Lt(p.rng.fine_uniform(), value));
  const I whole = hn::Min(to_int(hn::Min(value, splat(1e6f))), splat_int(kMostShadowRays));
  const I rays = select(chosen, splat_int(1), where(hn::AndNot(few, positive), whole));
  const F weight = share * to.factor / select(chosen, value, to_float(hn::Max(rays, splat_int(1))));
  const Random::Seed seed = p.rng.seed();
  Records& q = m.shadows;
  q.reserve(kLanes * kMostShadowRays);
  for (int k = 0;; ++k) {
    const M on = mask(hn::Gt(rays, splat_int(k)));
    const std::size_t rays_now = count(on);
    if (rays_now == 0) break;
    Random own = Random::stream(seed, k);
    const F depth = own.exponential();
    p.put_place(on, q);
    p.put_random(on, own, q);
    pack(on, to.direction.x, q[kDX] + q.n), pack(on, to.direction.y, q[kDY] + q.n);
    pack(on, to.direction.z, q[kDZ] + q.n);
    for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) {
      pack(on, p.w[c] * weight, q[kW0 + c] + q.n);
    }
    pack(on, depth, q[kDepth] + q.n);
    if (s.limited) pack(on, to.distance, q[kLeft] + q.n);
    if (s.ratio) store(splat(1), q[kPdf] + q.n);
    if (s.many) pack(on, p.ray, q.bits(kRay) + q.n);
    if (s.times) pack(on, p.time, q[kTime] + q.n);
    U id = (p.id & splat_bits(kMostSlots - 1)) | hn::ShiftLeft<16>(light);
    if (s.orders) {
      const U times = hn::Min(hn::ShiftRight<16>(p.id), splat_bits(2));
      id = id | hn::ShiftLeft<30>(times);
    }
    pack(on, id, q.bits(kId) + q.n);
    q.n += rays_now;
    m.counts.shadow_rays += rays_now;
  }
}

/// Of many lights each path asks some (THEORY.md, T5.19), drawn lane by lane.
template <bool kGuided, class ComponentKind>
HWY_NOINLINE void ask_some_lights(const WavefrontScene& s, WavefrontMemory& m,
                                  Paths<ComponentKind>& p) {
  const LaneStreams streams(p.rng);
  const LanePlaces place(s, m, p);
  std::array<TowardsByLane, kAsked> to;
  alignas(64) std::uint32_t light[kAsked][kLanes] = {}, row[kLanes];
  alignas(64) float importance[kAsked][kLanes] = {};
  store(as_bits(p.row), row);
  const std::size_t lights = s.setup.light.sources.size();
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    Rng own = streams.of(k, lights + 1);
    const float* importances = nullptr;
    if constexpr (kGuided) {
      importances = s.importance()->shadow_importances() + row[k] * (lights + 1);
    }
    std::size_t asked = 0;
    const auto ask = [&](std::size_t i, float times) {
      if (s.volume.asks_lamps) times *= share_of_collision(*m.colliding[k], s.setup.lamps[i]);
      ask_light(s, i, place(k), times, k, own, to[asked]);
      light[asked][k] = std::uint32_t(i), importance[asked][k] = kGuided ? importances[i] : 1;
      ++asked;
    };
    s.setup.light.many->draw(AtPlace{place(k)}, kAsked, importances, m.light_cut, own, ask);
  }
  for (std::size_t k = 0; k < std::size_t(kAsked); ++k) {
    add_shadow_rays(s, m, to[k].in_lanes(), load(light[k]), load(importance[k]), p);
  }
}

/// What a lamp brings to collisions, of which flights bring the rest.
template <class ComponentKind>
HWY_NOINLINE void leave_to_flights(const WavefrontMemory& m, const Lamp& lamp,
                                   const Paths<ComponentKind>& p, Towards& to) {
  alignas(64) float shares[kLanes] = {};
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    shares[k] = share_of_collision(*m.colliding[k], lamp);
  }
  const F share = load(shares);
  to.radiance = {to.radiance.x * share, to.radiance.y * share, to.radiance.z * share};
  to.factor = to.factor * share;
}

/// Shadow rays to all lights of the scene that are to be asked. `from` is the number of the first
/// lane's collision.
template <bool kGuided, class ComponentKind>
HWY_INLINE void ask_lights(const WavefrontScene& s, WavefrontMemory& m, std::size_t from,
                           Paths<ComponentKind>& p) {
  const std::size_t lights = s.setup.light.sources.size();
  if (s.volume.asks_lamps) keep_flights(s, m, from, bits_of(p.alive));
  if (s.drawn) ask_some_lights<kGuided>(s, m, p);
  for (std::size_t light = s.drawn ? lights : 0; light < s.lights.size(); ++light) {
    F importance = splat(1);
    if constexpr (kGuided) {
      importance =
          gather(s.importance()->shadow_importances() + light, p.row * splat_int(int(lights) + 1));
    }
    Towards to = sample_light(s, m, light, p, p.rng);
    if (s.volume.asks_lamps && light < lights) leave_to_flights(m, s.setup.lamps[light], p, to);
    add_shadow_rays(s, m, to, splat_bits(std::uint32_t(light)), importance, p);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
