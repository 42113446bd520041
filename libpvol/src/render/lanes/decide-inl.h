// The stage of decisions: which tentative collisions are real. In passes over all events, each of
// which fetches what the next one reads: bounds, micro-bounds, look-ups.

#if defined(PVOL_LANE_DECIDE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_DECIDE_INL_H
#undef PVOL_LANE_DECIDE_INL_H
#else
#define PVOL_LANE_DECIDE_INL_H
#endif

#include "pvol/field/brick_field.h"
#include "render/lanes/flights-inl.h"
#include "render/lanes/guide-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

HWY_INLINE void prefetch(const void* p) { __builtin_prefetch(p, 0, 3); }

/// Draws the events' u; those below the minorant are real. Of the rest, where their samples are.
HWY_NOINLINE void decide_by_bounds(const LaneScene& s, LaneMemory& m) {
  Events& e = m.events;
  const Records& q = m.flying;
  const int cubes = kLeafEdge >> s.micro_shift;
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at);
    const Place p(s.bounds, load(&e.x[at]), load(&e.y[at]), load(&e.z[at]));
    const I leaf = where(on, p.leaf), source = where(on, as_int(load(&e.source[at])));
    const U word = gather(s.bounds.word.data(), leaf);
    Random rng{gather(q.bits(kRng0), source), gather(q.bits(kRng1), source)};
    const F u = rng.fine_uniform();
    store(rng.s0, &e.rng0[at]), store(rng.s1, &e.rng1[at]);
    store(u * majorant(word), &e.mu[at]);
    const M real = hn::And(on, hn::Lt(u, minorant_share(word)));
    const M open = hn::AndNot(real, on);
    e.real[at / kLanes] = bits_of(real);
    e.open[at / kLanes] = bits_of(open);

    const I brick = as_int(gather(s.bounds.brick.data(), where(open, leaf)));
    const I seven = splat_int(kLeafEdge - 1);
    const I x = p.x & seven, y = p.y & seven, z = p.z & seven;
    const auto index = [](I i, I j, I k, int edge) {
      return (i * splat_int(edge) + j) * splat_int(edge) + k;
    };
    const I sample = brick * splat_int(kFieldSamples) + index(x, y, z, kFieldEdge);
    store(as_bits(brick), &e.brick[at]);
    store(as_bits(sample), &e.sample[at]);
    if (s.micro_codes == nullptr) continue;
    const auto cube_of = [&](I cell) { return hn::ShiftRightSame(cell, s.micro_shift); };
    const I cube =
        brick * splat_int(cubes * cubes * cubes) + index(cube_of(x), cube_of(y), cube_of(z), cubes);
    store(as_bits(cube), &e.cube[at]);
    for (std::uint32_t lanes = bits_of(open); lanes != 0; lanes &= lanes - 1) {
      prefetch(s.micro_codes + e.cube[at + std::size_t(std::countr_zero(lanes))]);
    }
  }
}

/// Lists an event's look-ups, whose samples are fetched.
HWY_INLINE void list_undecided(const LaneScene& s, Events& e, std::size_t at, M open) {
  constexpr int kY = kFieldEdge, kX = kFieldEdge * kFieldEdge;
  const std::size_t before = e.undecided;
  pack(open, hn::Iota(kU, std::uint32_t(at)), &e.which[before]);
  pack(open, load(&e.sample[at]), &e.at[before]);
  e.undecided += count(open);
  for (std::size_t k = before; k < e.undecided; ++k) {
    const float* const p = s.samples + e.at[k];
    prefetch(p), prefetch(p + kY), prefetch(p + kX), prefetch(p + kX + kY);
  }
}

/// Decides what micro-bounds can, and lists the rest.
HWY_NOINLINE void decide_by_micro_bounds(const LaneScene& s, LaneMemory& m) {
  Events& e = m.events;
  e.undecided = 0;
  const F scale = splat(s.volume.volume.density.scale);
  const auto* const pairs = reinterpret_cast<const std::uint32_t*>(s.micro_codes);
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    M open = mask_of(e.open[at / kLanes]);
    if (s.micro_codes != nullptr) {
      const I cube = where(open, as_int(load(&e.cube[at])));
      const I brick = where(open, as_int(load(&e.brick[at])));
      // Two cubes' codes share a word, the first in its lower half.
      const U word = gather(pairs, hn::ShiftRight<1>(cube));
      const M upper = mask(hn::TestBit(cube, splat_int(1)));
      const U code = select(upper, hn::ShiftRight<16>(word), word);
      const F base = gather(s.micro_scales, brick + brick);
      const F step = gather(s.micro_scales + 1, brick + brick);
      const auto bound = [&](U c) {  // rounded as micro_range does
        return scale * (base + to_float(as_int(c & splat_bits(255))) * step);
      };
      const F mu = load(&e.mu[at]);
      const M real = hn::And(open, hn::Lt(mu, bound(code)));
      e.real[at / kLanes] |= bits_of(real);
      open = hn::And(hn::AndNot(real, open), hn::Lt(mu, bound(hn::ShiftRight<8>(code))));
    }
    list_undecided(s, e, at, open);
  }
}

/// Density at places in cells whose first samples are at `index`, as density_in_brick rounds it.
template <LookUp kLookUp>
HWY_INLINE F look_up(const float* samples, I index, F x, F y, F z) {
  constexpr int kY = kFieldEdge, kX = kFieldEdge * kFieldEdge;
  if constexpr (kLookUp == LookUp::nearest) {
    const auto step = [](F f, int stride) {
      return where(hn::Ge(f, splat(0.5f)), splat_int(stride));
    };
    return gather(samples, index + step(x, kX) + step(y, kY) + step(z, 1));
  } else {
    const auto at = [&](int offset) { return gather(samples + offset, index); };
    const auto lerp = [](F a, F b, F t) { return a + (b - a) * t; };
    const F c00 = lerp(at(0), at(1), z), c01 = lerp(at(kY), at(kY + 1), z);
    const F c10 = lerp(at(kX), at(kX + 1), z), c11 = lerp(at(kX + kY), at(kX + kY + 1), z);
    return lerp(lerp(c00, c01, y), lerp(c10, c11, y), x);
  }
}

/// Decides the rest.
template <LookUp kLookUp>
HWY_NOINLINE void decide_by_look_ups(const LaneScene& s, LaneMemory& m) {
  Events& e = m.events;
  const F scale = splat(s.volume.volume.density.scale);
  for (std::size_t at = 0; at < e.undecided; at += kLanes) {
    const M on = first(e.undecided - at);
    const I which = where(on, as_int(load(&e.which[at])));
    const I index = where(on, as_int(load(&e.at[at])));
    const auto fraction = [&](const Events::Array<float>& of) {
      const F v = gather(of.data(), which);
      return v - hn::Floor(v);
    };
    const F rho = look_up<kLookUp>(s.samples, index, fraction(e.x), fraction(e.y), fraction(e.z));
    const M real = hn::And(on, hn::Lt(gather(e.mu.data(), which), scale * rho));
    for (std::uint32_t lanes = bits_of(real); lanes != 0; lanes &= lanes - 1) {
      const std::uint32_t event = e.which[at + std::size_t(std::countr_zero(lanes))];
      e.real[event / kLanes] |= 1u << (event % kLanes);
    }
  }
}

/// Events of a register on their way to a queue: their places, and the rest of the rays they were.
struct Moving {
  F x, y, z, dx, dy, dz, w0, w1, w2, pdf;
  U rng0, rng1, id;

  HWY_INLINE Moving(const LaneScene& s, const LaneMemory& m, std::size_t at, M on) {
    const Events& e = m.events;
    const Records& q = m.flying;
    x = load(&e.x[at]), y = load(&e.y[at]), z = load(&e.z[at]);
    const I source = where(on, as_int(load(&e.source[at])));
    dx = gather(q[kDX], source), dy = gather(q[kDY], source), dz = gather(q[kDZ], source);
    w0 = gather(q[kW0], source);
    id = gather(q.bits(kId), source);
    if (!s.one_lobe) w1 = gather(q[kW1], source), w2 = gather(q[kW2], source);
    if (s.weighted) pdf = gather(q[kPdf], source);
  }

  HWY_INLINE void put(const LaneScene& s, M chosen, const Random& rng, Records& to) const {
    const std::size_t n = to.n;
    pack(chosen, x, to[kX] + n), pack(chosen, y, to[kY] + n), pack(chosen, z, to[kZ] + n);
    pack(chosen, dx, to[kDX] + n), pack(chosen, dy, to[kDY] + n), pack(chosen, dz, to[kDZ] + n);
    pack(chosen, w0, to[kW0] + n);
    pack(chosen, id, to.bits(kId) + n);
    pack(chosen, rng.s0, to.bits(kRng0) + n), pack(chosen, rng.s1, to.bits(kRng1) + n);
    if (!s.one_lobe) pack(chosen, w1, to[kW1] + n), pack(chosen, w2, to[kW2] + n);
    if (s.weighted) pack(chosen, pdf, to[kPdf] + n);
    to.n += count(chosen);
  }
};

/// Adds the rows of the importance to real collisions of guided paths, and fetches them.
HWY_INLINE void put_rows(const LaneScene& s, const Importance& importance, const Moving& e, M real,
                         Records& to) {
  const Place p(s.bounds, e.x, e.y, e.z);
  std::uint32_t* const rows = to.bits(kAux) + to.n;
  pack(real, as_bits(row_of(importance.cells(), p.x, p.y, p.z)), rows);
  const std::size_t lights = s.setup.lights.size() + 1;
  for (std::size_t k = 0; k < count(real); ++k) {
    prefetch(&importance.rows()[rows[k]]);
    prefetch(importance.shadow_worths() + rows[k] * lights);
  }
}

HWY_NOINLINE void count_decisions(LaneMemory& m, const LaneScene& s, Tally& tally) {
  const Events& e = m.events;
  tally.bounds_tests += e.n;
  tally.lookups += e.undecided;
  for (std::size_t k = 0; k < (e.n + kLanes - 1) / kLanes; ++k) {
    if (s.micro_codes != nullptr) tally.bounds_tests += std::size_t(std::popcount(e.open[k]));
    const std::uint32_t on = bits_of(first(e.n - k * kLanes));
    const std::uint32_t* const sources = &e.source[k * kLanes];
    count_each(m, m.flying, sources, on, PixelCounter::bounds_tests);
    if (s.micro_codes != nullptr) {
      count_each(m, m.flying, sources, e.open[k], PixelCounter::bounds_tests);
    }
    tally.null_collisions += std::size_t(std::popcount(on & ~e.real[k]));
  }
  for (std::size_t k = 0; k < e.undecided; ++k) {
    count_each(m, m.flying, &e.source[e.which[k]], 1, PixelCounter::lookups);
  }
}

/// Real collisions go to `real`, or nowhere where it is null; null ones fly on in `back`.
HWY_NOINLINE void decide(const LaneScene& s, LaneMemory& m, Records& back, Records* real,
                         Tally& tally) {
  Events& e = m.events;
  decide_by_bounds(s, m);
  decide_by_micro_bounds(s, m);
  if (s.volume.volume.density.look_up == LookUp::nearest) {
    decide_by_look_ups<LookUp::nearest>(s, m);
  } else {
    decide_by_look_ups<LookUp::trilinear>(s, m);
  }
  if (s.count) count_decisions(m, s, tally);
  back.reserve(e.n);
  if (real != nullptr) real->reserve(e.n);
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at), is_real = mask_of(e.real[at / kLanes]);
    Random rng{load(&e.rng0[at]), load(&e.rng1[at])};
    const M null = hn::AndNot(is_real, on);
    const Moving moving(s, m, at, on);
    if (real != nullptr) {
      if (s.importance() != nullptr) put_rows(s, *s.importance(), moving, is_real, *real);
      moving.put(s, is_real, rng, *real);
    }
    pack(null, rng.exponential(), back[kDepth] + back.n);
    if (s.limited) pack(null, load(&e.left[at]), back[kLeft] + back.n);
    moving.put(s, null, rng, back);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
