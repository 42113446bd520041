// The stage of real collisions: emission, roulette, shadow rays, splitting (THEORY.md, T5.2, T5.4,
// T5.5).

#if defined(PVOL_LANE_COLLIDE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_COLLIDE_INL_H
#undef PVOL_LANE_COLLIDE_INL_H
#else
#define PVOL_LANE_COLLIDE_INL_H
#endif

#include "render/engine/wavefront/colors-inl.h"
#include "render/engine/wavefront/on_the_way-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Multiplies the weights by the albedos of the components at the paths' places. `found`: the
/// colours of those that vary are known.
template <class ComponentKind>
HWY_INLINE void weaken(const WavefrontScene& s, WavefrontMemory& m, bool found,
                       Paths<ComponentKind>& p) {
  const ComponentKind component(s, p.component);
  const bool varies = ComponentKind::kWeights > 1 && s.setup.albedo_varies;
  if (varies && !found) find_colors(s, m, p);
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) {
    const F albedo = component.albedo_of(c);
    p.w[c] = p.w[c] * (varies ? albedo * load(m.colors[c].data()) : albedo);
  }
}

/// What collisions emit, lane by lane.
template <class ComponentKind>
HWY_NOINLINE void add_emission(const WavefrontScene& s, WavefrontMemory& m,
                               const Paths<ComponentKind>& p) {
  alignas(64) float w[ComponentKind::kWeights][kLanes];
  alignas(64) std::uint32_t id[kLanes];
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) store(p.w[c], w[c]);
  store(p.id, id);
  const LanePlaces places(s, m, p);
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    if (s.many && !places.brings_light(k)) continue;
    if (ComponentKind::kWeights == 1 && !s.orders && s.setup.volumes.size() == 1) {
      m.slots.add_collision(slot_of(id[k]), w[0][k]);
    } else {
      constexpr std::size_t kSecond = ComponentKind::kWeights / 2,
                            kThird = ComponentKind::kWeights - 1;
      m.slots.add(slot_of(id[k]), number_of(id[k]), [&](PathResult& r) {
        const Rgb color(m.colors[0][k], m.colors[1][k], m.colors[2][k]);
        const bool varies = s.setup.albedo_varies;
        add_emitted(s.setup, varies ? mean_of(s.volume.components, color) : s.volume.mean,
                    Rgb(w[0][k], w[kSecond][k], w[kThird][k]), r);
      });
    }
  }
}

/// Importance below which guided paths are ended by roulette, and above which they are split, and
/// the most that one of them is split into.
inline constexpr float kEndBelow = 0.5f, kSplitAbove = 2, kMostCopies = 8;

/// The roulette of plain paths, by throughput, below a threshold.
template <class ComponentKind>
HWY_INLINE void end_faint(Paths<ComponentKind>& p, float threshold) {
  const F most = p.largest();
  const M faint = hn::Lt(most, splat(threshold));
  const M stays = hn::Lt(p.rng.fine_uniform() * splat(threshold), most);
  p.scale(faint, splat(threshold) / most);
  p.alive = hn::AndNot(hn::AndNot(stays, faint), p.alive);
}

/// That of guided paths, by their estimated contribution, before the albedo. Bright pixels do not
/// end them sooner (THEORY.md, T5.5).
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
HWY_INLINE void put_paths(const WavefrontScene& s, WavefrontMemory& m, Paths<ComponentKind>& p,
                          I copies, M turned) {
  m.straight.reserve(kLanes * std::size_t(kMostCopies));
  m.turned.reserve(kLanes * std::size_t(kMostCopies));
  const auto put = [&](M on, const Random& rng, Records& q) {
    p.put_place(on, q);
    p.put_random(on, rng, q);
    pack(on, p.from.x, q[kDX] + q.n), pack(on, p.from.y, q[kDY] + q.n);
    pack(on, p.from.z, q[kDZ] + q.n);
    for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) pack(on, p.w[c], q[kW0 + c] + q.n);
    pack(on, p.id, q.bits(kId) + q.n);
    pack(on, p.ray, q.bits(kRay) + q.n);
    if (s.times) pack(on, p.time, q[kTime] + q.n);
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

template <class ComponentKind>
HWY_INLINE F importance_of_pixels(const WavefrontMemory& m, const Paths<ComponentKind>& p) {
  const U slot = p.id & splat_bits(kMostSlots - 1);
  return gather(m.slots.importance.data(), where(p.alive, as_int(slot)));
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
    if (s.emits) {
      if (s.setup.albedo_varies) find_colors(s, m, p);
      add_emission(s, m, p);
    }
    F contribution = splat(1);
    if constexpr (kGuided) {
      const Importance& importance = *s.importance();
      if (s.setup.pixel_importance) p.pixel = importance_of_pixels(m, p);
      p.row = where(p.alive, as_int(load(q.bits(kAux) + at)));
      const F to_axis = one_minus_cos(p.from, axis_of(importance, p.row));
      const F in_any_pixel = p.largest() * importance_of(importance, p.row, to_axis);
      end_by_contribution(p, in_any_pixel * hn::Max(p.pixel, splat(1)));
      contribution = in_any_pixel * p.pixel;
    }
    if (s.setup.max_bounces <= kMostBounces) {
      const I bounces = as_int(hn::ShiftRight<16>(p.id));
      p.alive = hn::And(p.alive, mask(hn::Lt(bounces, splat_int(int(s.setup.max_bounces)))));
    }
    if (s.counts_collisions) {
      const M few = mask(hn::Lt(as_int(hn::ShiftRight<16>(p.id)), splat_int(kMostBounces)));
      p.id = p.id + as_bits(where(few, splat_int(int(kMostSlots))));
    }
    weaken(s, m, s.emits, p);
    if constexpr (!kGuided) end_faint(p, kPathRoulette);
    p.alive = hn::And(p.alive, hn::Gt(p.largest(), splat(0)));
    ask_lights<kGuided>(s, m, at, p);
    if (s.setup.samples_fires()) ask_fires(s, m, p);
    if constexpr (kGuided) {
      const M split = hn::Gt(contribution, splat(kSplitAbove));
      const I copies =
          select(split, to_int(hn::Min(contribution, splat(kMostCopies))), splat_int(1));
      p.scale(split, splat(1) / to_float(copies));
      put_paths(s, m, p, copies, turns(*s.importance(), p.row));
    } else {
      put_paths(s, m, p, splat_int(1), first(0));
    }
  }
  q.n = 0;
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
