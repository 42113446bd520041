// What becomes of events: real collisions and rays that fly on go to their queues, and the work is
// counted.

#if defined(PVOL_LANE_EVENTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_EVENTS_INL_H
#undef PVOL_LANE_EVENTS_INL_H
#else
#define PVOL_LANE_EVENTS_INL_H
#endif

#include "pvol/track/transmittance.h"
#include "render/engine/wavefront/guide-inl.h"
#include "render/engine/wavefront/wavefront_memory.h"
#include "volume/simd/decide-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Where the renderer counts the work of flights and decisions: in the tally of the whole picture
/// and in those of samples, one lane at a time.
struct SampleCounts {
  const WavefrontScene& s;
  WavefrontMemory& m;
  Tally& tally;

  HWY_INLINE bool on() const { return s.count; }

  HWY_NOINLINE void add_segments(const std::uint32_t* sources, std::uint32_t lanes) {
    tally.segments += std::size_t(std::popcount(lanes));
    add_each(sources, lanes, PixelCounter::segments);
  }

  void add_decisions() {
    const Events& e = m.events;
    const bool micro = s.field.micro_codes != nullptr || s.field.codes != nullptr;
    tally.bounds_tests += e.n;
    tally.lookups += e.undecided;
    for (std::size_t k = 0; k < (e.n + kLanes - 1) / kLanes; ++k) {
      if (micro) tally.bounds_tests += std::size_t(std::popcount(e.open[k]));
      const std::uint32_t all = bits_of(first(e.n - k * kLanes));
      const std::uint32_t* const sources = &e.source[k * kLanes];
      add_each(sources, all, PixelCounter::bounds_tests);
      if (micro) add_each(sources, e.open[k], PixelCounter::bounds_tests);
      tally.null_collisions += std::size_t(std::popcount(all & ~e.real[k]));
    }
    for (std::size_t k = 0; k < e.undecided; ++k) {
      add_each(&e.source[e.which[k]], 1, PixelCounter::lookups);
    }
  }

  /// Events that were all looked up, of which so many were passed.
  void add_weighed(std::size_t passed) {
    const Events& e = m.events;
    tally.lookups += e.n, tally.null_collisions += passed;
    for (std::size_t k = 0; k < e.n; ++k) add_each(&e.source[k], 1, PixelCounter::lookups);
  }

 private:
  void add_each(const std::uint32_t* sources, std::uint32_t lanes, PixelCounter counter) {
    for (; lanes != 0; lanes &= lanes - 1) {
      const std::uint32_t id = m.flying.bits(kId)[sources[std::countr_zero(lanes)]];
      ++m.slots.counts[slot_of(id)][std::size_t(counter)];
    }
  }
};

/// Events of a register on their way to a queue: rays, and what the scene's paths carry besides.
struct InFlight {
  RaysInFlight rays;
  F w0, w1 = splat(0), w2 = w1, pdf = w1, time = w1;
  V from{w1, w1, w1}, step = from;
  U ray = splat_bits(0);

  HWY_INLINE InFlight(const WavefrontScene& s, const WavefrontMemory& m, std::size_t at, M on)
      : rays(m, at, on) {
    const Records& q = m.flying;
    w0 = gather(q[kW0], rays.source);
    if (!s.one_lobe) w1 = gather(q[kW1], rays.source), w2 = gather(q[kW2], rays.source);
    if (s.weighted) pdf = gather(q[kPdf], rays.source);
    if (s.lines) {
      from = {gather(q[kFromX], rays.source), gather(q[kFromY], rays.source),
              gather(q[kFromZ], rays.source)};
    }
    if (s.many) {
      step = {gather(q[kStepX], rays.source), gather(q[kStepY], rays.source),
              gather(q[kStepZ], rays.source)};
      ray = gather(q.bits(kRay), rays.source);
      if (s.times) time = gather(q[kTime], rays.source);
    }
  }

  HWY_INLINE void put(const WavefrontScene& s, M chosen, const Random& rng, Records& to) const {
    const std::size_t n = to.n;
    rays.put(chosen, rng, to);
    pack(chosen, w0, to[kW0] + n);
    if (!s.one_lobe) pack(chosen, w1, to[kW1] + n), pack(chosen, w2, to[kW2] + n);
    if (s.weighted) pack(chosen, pdf, to[kPdf] + n);
    if (s.lines) {
      pack(chosen, from.x, to[kFromX] + n), pack(chosen, from.y, to[kFromY] + n);
      pack(chosen, from.z, to[kFromZ] + n);
    }
    if (s.many) {
      pack(chosen, step.x, to[kStepX] + n), pack(chosen, step.y, to[kStepY] + n);
      pack(chosen, step.z, to[kStepZ] + n), pack(chosen, ray, to.bits(kRay) + n);
      if (s.times) pack(chosen, time, to[kTime] + n);
    }
    to.n += count(chosen);
  }
};

/// The state of the random numbers of records.
HWY_INLINE Random random_of(const Records& q, I index) {
  return {gather(q.bits(kRng0), index), gather(q.bits(kRng1), index)};
}

/// Chosen events of a register fly on in `back`.
HWY_INLINE void fly_on(const WavefrontScene& s, const Events& e, std::size_t at, M chosen,
                       const InFlight& in_flight, Random& rng, Records& back) {
  pack(chosen, rng.exponential(), back[kDepth] + back.n);
  if (s.limited) pack(chosen, load(&e.left[at]), back[kLeft] + back.n);
  in_flight.put(s, chosen, rng, back);
}

/// Adds the rows of the importance to real collisions of guided paths, and fetches them.
HWY_INLINE void put_rows(const WavefrontScene& s, const Importance& importance,
                         const RaysInFlight& e, M real, Records& to) {
  const Place p(s.field.bounds, e.x, e.y, e.z);
  std::uint32_t* const rows = to.bits(kAux) + to.n;
  pack(real, as_bits(row_of(importance.cells(), p.x, p.y, p.z)), rows);
  const std::size_t lights = s.setup.light.sources.size() + 1;
  for (std::size_t k = 0; k < count(real); ++k) {
    prefetch(&importance.rows()[rows[k]]);
    prefetch(importance.shadow_importances() + rows[k] * lights);
  }
}

/// decide() where the extinction differs by channel: one decision for all channels, by what the
/// rays carry of each (THEORY.md, T3.9).
template <LookUp kLookUp>
HWY_NOINLINE void decide_by_channel(const WavefrontScene& s, WavefrontMemory& m, Records& back,
                                    Records& real, Tally& tally) {
  const Events& e = m.events;
  const F one = splat(1);
  const std::size_t before = back.n;
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at);
    InFlight in_flight(s, m, at, on);
    Random rng = random_of(m.flying, in_flight.rays.source);
    const F share = share_of_majorant<kLookUp>(s.field, e, at, on);
    const F real_0 = splat(s.share.x) * share, real_1 = splat(s.share.y) * share,
            real_2 = splat(s.share.z) * share;
    const F w0 = hn::Abs(in_flight.w0), w1 = hn::Abs(in_flight.w1), w2 = hn::Abs(in_flight.w2);
    const F carried = w0 + w1 + w2;
    const F p = select(hn::Gt(carried, splat(0)),
                       (w0 * real_0 + w1 * real_1 + w2 * real_2) / carried, share);
    const M collides = hn::And(on, hn::Lt(rng.fine_uniform(), p));
    const auto weigh = [&](F& w, F of_real) {
      w = w * select(collides, of_real / p, (one - of_real) / (one - p));
    };
    weigh(in_flight.w0, real_0), weigh(in_flight.w1, real_1), weigh(in_flight.w2, real_2);
    const M null = hn::AndNot(collides, on);
    if (s.importance() != nullptr && !s.many)
      put_rows(s, *s.importance(), in_flight.rays, collides, real);
    in_flight.put(s, collides, rng, real);
    fly_on(s, e, at, null, in_flight, rng, back);
  }
  if (s.count) SampleCounts{s, m, tally}.add_weighed(back.n - before);
}

/// Real collisions go to `real`, or nowhere where it is null; null ones fly on in `back`.
HWY_NOINLINE void decide(const WavefrontScene& s, WavefrontMemory& m, Records& back, Records* real,
                         Tally& tally) {
  const Events& e = m.events;
  if (s.setup.by_channel) {  // whose shadow rays have weights, and are not decided
    fetch_samples(s.field, m);
    back.reserve(e.n), real->reserve(e.n);
    return s.field.look_up == LookUp::nearest
               ? decide_by_channel<LookUp::nearest>(s, m, back, *real, tally)
               : decide_by_channel<LookUp::trilinear>(s, m, back, *real, tally);
  }
  decide(s.field, m);
  if (s.count) SampleCounts{s, m, tally}.add_decisions();
  back.reserve(e.n);
  if (real != nullptr) real->reserve(e.n);
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at), is_real = mask_of(e.real[at / kLanes]);
    Random rng{load(&e.rng0[at]), load(&e.rng1[at])};
    const M null = hn::AndNot(is_real, on);
    const InFlight in_flight(s, m, at, on);
    if (real != nullptr) {
      if (s.importance() != nullptr && !s.many)
        put_rows(s, *s.importance(), in_flight.rays, is_real, *real);
      in_flight.put(s, is_real, rng, *real);
    }
    fly_on(s, e, at, null, in_flight, rng, back);
  }
}

/// Shadow rays of the slice pass their events with weights, and fly on in `back` but for those that
/// a roulette drops; dropped(record) is told of these. kPdf holds the products (T3.3), or where
/// channels differ the largest of them, which the weights have in them then (T3.9).
template <LookUp kLookUp, class Dropped>
HWY_NOINLINE void weigh_by(const WavefrontScene& s, WavefrontMemory& m, Records& back,
                           const Dropped& dropped) {
  const Events& e = m.events;
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at);
    InFlight in_flight(s, m, at, on);
    Random rng = random_of(m.flying, in_flight.rays.source);
    const F share = share_of_majorant<kLookUp>(s.field, e, at, on);
    const auto passed = [&](float of) { return splat(1) - splat(of) * share; };
    const bool by_channel = s.setup.by_channel;
    const F product =
        in_flight.pdf * (by_channel ? passed(min_component(s.share)) : splat(1) - share);
    const F least = splat(kTransmittanceRoulette);
    const M low = hn::Lt(product, least);
    const M ends = hn::And(on, hn::AndNot(hn::Lt(rng.fine_uniform() * least, product), low));
    in_flight.pdf = select(low, least, product);
    if (by_channel) {
      const F lifted = select(low, least / product, splat(1));
      in_flight.w0 = in_flight.w0 * passed(s.share.x) * lifted;
      in_flight.w1 = in_flight.w1 * passed(s.share.y) * lifted;
      in_flight.w2 = in_flight.w2 * passed(s.share.z) * lifted;
    }
    for (std::uint32_t lanes = bits_of(ends); lanes != 0; lanes &= lanes - 1) {
      dropped(e.source[at + std::size_t(std::countr_zero(lanes))]);
    }
    const M stays = hn::AndNot(ends, on);
    fly_on(s, e, at, stays, in_flight, rng, back);
  }
}

template <class Dropped>
HWY_INLINE void weigh(const WavefrontScene& s, WavefrontMemory& m, Records& back, Tally& tally,
                      const Dropped& dropped) {
  fetch_samples(s.field, m);
  back.reserve(m.events.n);
  if (s.count) SampleCounts{s, m, tally}.add_weighed(m.events.n);
  if (s.field.look_up == LookUp::nearest) {
    weigh_by<LookUp::nearest>(s, m, back, dropped);
  } else {
    weigh_by<LookUp::trilinear>(s, m, back, dropped);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
