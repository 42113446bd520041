// The stage of real collisions: emission, roulette, shadow rays, splitting (THEORY.md, T5.2, T5.4,
// T5.5).

#if defined(PVOL_LANE_COLLIDE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_COLLIDE_INL_H
#undef PVOL_LANE_COLLIDE_INL_H
#else
#define PVOL_LANE_COLLIDE_INL_H
#endif

#include "render/engine/guided_tracer.h"
#include "render/engine/wavefront/events-inl.h"
#include "render/path/gather_light.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Paths at their collisions.
template <class ComponentKind>
struct Paths {
  M alive;
  F x, y, z;
  V from;  ///< direction of the flight
  std::array<F, ComponentKind::kWeights> w;
  Random rng;
  U id;
  I component;
  I row;  ///< of the importance

  HWY_INLINE Paths(const Records& q, std::size_t at)
      : alive(first(q.n - at)),
        x(load(q[kX] + at)),
        y(load(q[kY] + at)),
        z(load(q[kZ] + at)),
        from{load(q[kDX] + at), load(q[kDY] + at), load(q[kDZ] + at)},
        rng{load(q.bits(kRng0) + at), load(q.bits(kRng1) + at)},
        id(load(q.bits(kId) + at)),
        component(splat_int(0)),
        row(splat_int(0)) {
    for (std::size_t c = 0; c < w.size(); ++c) w[c] = load(q[kW0 + c] + at);
  }

  HWY_INLINE F largest() const {
    F most = hn::Abs(w[0]);
    for (std::size_t c = 1; c < w.size(); ++c) most = hn::Max(most, hn::Abs(w[c]));
    return most;
  }
  HWY_INLINE void scale(M chosen, F factor) {
    for (F& v : w) v = select(chosen, v * factor, v);
  }

  HWY_INLINE void put_place(M chosen, Records& to) const {
    pack(chosen, x, to[kX] + to.n), pack(chosen, y, to[kY] + to.n), pack(chosen, z, to[kZ] + to.n);
  }
  HWY_INLINE void put_random(M chosen, const Random& r, Records& to) const {
    pack(chosen, r.s0, to.bits(kRng0) + to.n), pack(chosen, r.s1, to.bits(kRng1) + to.n);
  }
};

/// A direction to a light in each lane, as LightSample.
struct Towards {
  V direction;
  V radiance;
  F pdf, distance;
  F factor;  ///< of what a ray that arrives brings: the light's own radiance times it
};

/// Samples a picture of a sky, lane by lane. `number` is that of the sky among the lights.
HWY_NOINLINE Towards sample_sky(const WavefrontScene& s, std::size_t number, Random& rng) {
  alignas(64) std::uint32_t key[kLanes], counter[kLanes];
  store(rng.next(), key), store(rng.next(), counter);
  alignas(64) float d[3][kLanes], radiance[3][kLanes], pdf[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) {
    Rng own(key[k], counter[k], number);
    const LightSample l = s.setup.light.sky.sample(own);
    const Rgb more = l.radiance - s.setup.constant;
    for (int c = 0; c < 3; ++c) d[c][k] = l.direction[c], radiance[c][k] = more[c];
    pdf[k] = l.pdf;
  }
  return {{load(d[0]), load(d[1]), load(d[2])},
          {load(radiance[0]), load(radiance[1]), load(radiance[2])},
          load(pdf),
          splat(0x1p100f),
          splat(1)};
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
HWY_INLINE Towards sample_light(const WavefrontScene& s, std::size_t light,
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
  return sample_sky(s, light, rng);
}

/// Shadow rays to a light, as `shadowed` draws them; `importance` is that of a ray there.
template <class ComponentKind>
HWY_INLINE void add_shadow_rays(const WavefrontScene& s, WavefrontMemory& m, std::size_t light,
                                F importance, Paths<ComponentKind>& p) {
  const Towards to = sample_light(s, light, p, p.rng);
  const F pdf = ComponentKind(s, p.component).pdf(p.from, to.direction);
  const F share = select(hn::Gt(to.pdf, splat(0)), pdf / (to.pdf + pdf), pdf);
  const auto part = [&](float coefficient, std::size_t c, F radiance) {
    return splat(coefficient) * hn::Abs(p.w[ComponentKind::kWeights == 1 ? 0 : c] * radiance);
  };
  const F luminance = part(0.2126f, 0, to.radiance.x) + part(0.7152f, 1, to.radiance.y) +
                      part(0.0722f, 2, to.radiance.z);
  const F value = luminance * share * importance * splat(1 / s.setup.light.shadow_unit);
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
    U id = (p.id & splat_bits(kMostSlots - 1)) | splat_bits(std::uint32_t(light) << 16);
    if (s.orders) {
      const U times = hn::Min(hn::ShiftRight<16>(p.id), splat_bits(2));
      id = id | hn::ShiftLeft<24>(times);
    }
    pack(on, id, q.bits(kId) + q.n);
    q.n += rays_now;
    m.counts.shadow_rays += rays_now;
  }
}

/// What collisions emit, lane by lane.
template <class ComponentKind>
HWY_NOINLINE void add_emission(const WavefrontScene& s, WavefrontMemory& m,
                               const Paths<ComponentKind>& p) {
  alignas(64) float w[ComponentKind::kWeights][kLanes];
  alignas(64) std::uint32_t id[kLanes], component[kLanes];
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) store(p.w[c], w[c]);
  store(p.id, id), store(as_bits(p.component), component);
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    if (ComponentKind::kWeights == 1 && !s.orders) {
      m.slots.add_collision(slot_of(id[k]), w[0][k]);
    } else {
      constexpr std::size_t kSecond = ComponentKind::kWeights / 2,
                            kThird = ComponentKind::kWeights - 1;
      m.slots.add(slot_of(id[k]), number_of(id[k]), [&](PathResult& r) {
        add_emitted(s.setup, everywhere(s.volume.components[component[k]]),
                    Rgb(w[0][k], w[kSecond][k], w[kThird][k]), r);
      });
    }
  }
}

/// The roulette of plain paths, by throughput, below a threshold.
template <class ComponentKind>
HWY_INLINE void end_faint(Paths<ComponentKind>& p, float threshold) {
  const F most = p.largest();
  const M faint = hn::Lt(most, splat(threshold));
  const M stays = hn::Lt(p.rng.fine_uniform() * splat(threshold), most);
  p.scale(faint, splat(threshold) / most);
  p.alive = hn::AndNot(hn::AndNot(stays, faint), p.alive);
}

/// That of guided paths, by their estimated contribution, before the albedo.
template <class ComponentKind>
HWY_INLINE void end_by_contribution(Paths<ComponentKind>& p, F contribution) {
  const M low = hn::Lt(contribution, splat(kEndBelow));
  const M stays = hn::Lt(p.rng.fine_uniform(), contribution);
  p.scale(low, splat(1) / contribution);
  p.alive = hn::AndNot(hn::AndNot(stays, low), p.alive);
}

/// Passes paths on to be scattered, as often as they are split. `turned` are those whose directions
/// are chosen by importance.
template <class ComponentKind>
HWY_INLINE void put_paths(WavefrontMemory& m, Paths<ComponentKind>& p, I copies, M turned) {
  m.straight.reserve(kLanes * std::size_t(kMostCopies));
  m.turned.reserve(kLanes * std::size_t(kMostCopies));
  const auto put = [&](M on, const Random& rng, Records& q) {
    p.put_place(on, q);
    p.put_random(on, rng, q);
    pack(on, p.from.x, q[kDX] + q.n), pack(on, p.from.y, q[kDY] + q.n);
    pack(on, p.from.z, q[kDZ] + q.n);
    for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) pack(on, p.w[c], q[kW0 + c] + q.n);
    pack(on, p.id, q.bits(kId) + q.n);
    pack(on, as_bits(p.row), q.bits(kAux) + q.n);
    if constexpr (ComponentKind::kWeights > 1)
      pack(on, as_bits(p.component), q.bits(kComponent) + q.n);
    q.n += count(on);
  };
  const Random::Seed seed = p.rng.seed();
  Random rng = p.rng;
  for (int k = 0;; ++k) {
    const M on = hn::And(p.alive, mask(hn::Gt(copies, splat_int(k))));
    if (count(on) == 0) break;
    put(hn::AndNot(turned, on), rng, m.straight);
    put(hn::And(turned, on), rng, m.turned);
    rng = Random::stream(seed, k);
  }
}

template <bool kGuided, class ComponentKind>
HWY_NOINLINE void collide(const WavefrontScene& s, WavefrontMemory& m) {
  Records& q = m.collisions;
  m.counts.collisions += q.n;
  if (s.count) {
    for (std::size_t k = 0; k < q.n; ++k) {
      ++m.slots.counts[slot_of(q.bits(kId)[k])][std::size_t(PixelCounter::collisions)];
    }
  }
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    Paths<ComponentKind> p(q, at);
    p.component = ComponentKind::choose(s, p.rng);
    if (s.emits) add_emission(s, m, p);
    F contribution = splat(1);
    if constexpr (kGuided) {
      const Importance& importance = *s.importance();
      p.row = where(p.alive, as_int(load(q.bits(kAux) + at)));
      contribution = p.largest() * importance_of(importance, p.row,
                                                 one_minus_cos(p.from, splat(importance.axis())));
      end_by_contribution(p, contribution);
    } else if (s.setup.max_bounces <= kMostWavefrontBounces) {
      const I bounces = as_int(hn::ShiftRight<16>(p.id));
      p.alive = hn::And(p.alive, mask(hn::Lt(bounces, splat_int(int(s.setup.max_bounces)))));
    }
    if (s.counts_collisions) {
      const M few =
          mask(hn::Lt(as_int(hn::ShiftRight<16>(p.id)), splat_int(kMostWavefrontBounces)));
      p.id = p.id + as_bits(where(few, splat_int(int(kMostSlots))));
    }
    const ComponentKind component(s, p.component);
    for (std::size_t c = 0; c < p.w.size(); ++c) p.w[c] = p.w[c] * component.albedo_of(c);
    if constexpr (!kGuided) end_faint(p, kPathRoulette);
    p.alive = hn::And(p.alive, hn::Gt(p.largest(), splat(0)));
    const I lights = splat_int(int(s.setup.light.sources.size()) + 1);
    for (std::size_t light = 0; light < s.lights.size(); ++light) {
      F shadow_importance = splat(1);
      if constexpr (kGuided) {
        shadow_importance = gather(s.importance()->shadow_importances() + light, p.row * lights);
      }
      add_shadow_rays(s, m, light, shadow_importance, p);
    }
    if constexpr (kGuided) {
      const M split = hn::Gt(contribution, splat(kSplitAbove));
      const I copies =
          select(split, to_int(hn::Min(contribution, splat(kMostCopies))), splat_int(1));
      p.scale(split, splat(1) / to_float(copies));
      put_paths(m, p, copies, turns(*s.importance(), p.row));
    } else {
      put_paths(m, p, splat_int(1), first(0));
    }
  }
  q.n = 0;
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
