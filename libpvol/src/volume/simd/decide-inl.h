// The stage of decisions: which tentative collisions are real. In passes over all events, each of
// which fetches what the next one reads: bounds; codes of samples or micro-bounds; look-ups.

#if defined(PVOL_LANE_DECIDE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_DECIDE_INL_H
#undef PVOL_LANE_DECIDE_INL_H
#else
#define PVOL_LANE_DECIDE_INL_H
#endif

#include "pvol/field/sample_codes.h"
#include "volume/simd/look_up-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Draws the events' u; those below the minorant are real. Of the rest, where their samples are.
inline HWY_NOINLINE void decide_by_bounds(const SimdField& f, FlightMemory& m) {
  Events& e = m.events;
  const Records& q = m.flying;
  const int cubes = kLeafEdge >> f.micro_shift;
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at);
    const Place p(f.bounds, load(&e.x[at]), load(&e.y[at]), load(&e.z[at]));
    const I source = where(on, as_int(load(&e.source[at])));
    const U word = gather(f.bounds.word.data(), where(on, p.cube));
    Random rng{gather(q.bits(kRng0), source), gather(q.bits(kRng1), source)};
    const F u = rng.fine_uniform();
    store(rng.s0, &e.rng0[at]), store(rng.s1, &e.rng1[at]);
    store(u * majorant(word), &e.mu[at]);
    const M real = hn::And(on, hn::Lt(u, minorant_share(word)));
    const M open = hn::AndNot(real, on);
    e.real[at / kLanes] = bits_of(real);
    e.open[at / kLanes] = bits_of(open);

    const I brick = as_int(gather(f.bounds.brick.data(), where(open, p.leaf(f.bounds))));
    const CellInLeaf cell(p);
    store(as_bits(brick), &e.brick[at]);
    store(as_bits(cell.first_sample(brick)), &e.sample[at]);
    if (f.codes != nullptr) {
      for (std::uint32_t lanes = bits_of(open); lanes != 0; lanes &= lanes - 1) {
        const std::size_t k = at + std::size_t(std::countr_zero(lanes));
        prefetch_cell(f.codes + e.sample[k]);
        prefetch(f.code_scales + 2 * std::size_t(e.brick[k]));
      }
    }
    if (f.micro_codes == nullptr) continue;
    const auto cube_of = [&](I v) { return hn::ShiftRightSame(v, f.micro_shift); };
    const I cube = brick * splat_int(cubes * cubes * cubes) +
                   index_in_cube(cube_of(cell.x), cube_of(cell.y), cube_of(cell.z), cubes);
    store(as_bits(cube), &e.cube[at]);
    for (std::uint32_t lanes = bits_of(open); lanes != 0; lanes &= lanes - 1) {
      prefetch(f.micro_codes + e.cube[at + std::size_t(std::countr_zero(lanes))]);
    }
  }
}

/// By what look-ups find the samples at a register of events.
HWY_INLINE U shared_samples(const SimdField& f, const Events& e, std::size_t at) {
  const Place p(f.bounds, load(&e.x[at]), load(&e.y[at]), load(&e.z[at]));
  return as_bits(CellInLeaf(p).samples(f, as_int(load(&e.brick[at]))));
}

/// Lists an event's look-ups, whose samples are fetched.
HWY_INLINE void list_undecided(const SimdField& f, Events& e, std::size_t at, M open) {
  const std::size_t before = e.undecided;
  pack(open, hn::Iota(kU, std::uint32_t(at)), &e.which[before]);
  e.undecided += count(open);
  if (f.one_by_one != nullptr || f.moving != nullptr) return;
  pack(open, f.shared == nullptr ? load(&e.sample[at]) : shared_samples(f, e, at), &e.at[before]);
  for (std::size_t k = before; k < e.undecided; ++k) prefetch_samples(f, e.at[k]);
}

/// Decides what micro-bounds can, and lists the rest.
inline HWY_NOINLINE void decide_by_micro_bounds(const SimdField& f, Events& e) {
  e.undecided = 0;
  const F scale = splat(f.scale);
  const auto* const pairs = reinterpret_cast<const std::uint32_t*>(f.micro_codes);
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    M open = mask_of(e.open[at / kLanes]);
    if (f.micro_codes != nullptr) {
      const I cube = where(open, as_int(load(&e.cube[at])));
      const I brick = where(open, as_int(load(&e.brick[at])));
      // Two cubes' codes share a word, the first in its lower half.
      const U word = gather(pairs, hn::ShiftRight<1>(cube));
      const M upper = mask(hn::TestBit(cube, splat_int(1)));
      const U code = select(upper, hn::ShiftRight<16>(word), word);
      const F base = gather(f.micro_scales, brick + brick);
      const F step = gather(f.micro_scales + 1, brick + brick);
      const auto bound = [&](U c) {  // rounded as micro_range does
        return scale * (base + to_float(as_int(c & splat_bits(255))) * step);
      };
      const F mu = load(&e.mu[at]);
      const M real = hn::And(open, hn::Lt(mu, bound(code)));
      e.real[at / kLanes] |= bits_of(real);
      open = hn::And(hn::AndNot(real, open), hn::Lt(mu, bound(hn::ShiftRight<8>(code))));
    }
    list_undecided(f, e, at, open);
  }
}

/// What look-ups would compute from codes, at places in cells whose first codes are at `index`.
template <LookUp kLookUp>
HWY_INLINE F look_up_codes(const std::uint8_t* codes, I index, F x, F y, F z) {
  constexpr int kY = kFieldEdge, kX = kFieldEdge * kFieldEdge;
  const auto lowest = [](U word) { return to_float(as_int(word & splat_bits(255))); };
  if constexpr (kLookUp == LookUp::nearest) {
    return lowest(gather_bytes(codes, index + nearest_corner(x, y, z, {kX, kY, 1})));
  } else {
    const auto lerp = [](F a, F b, F t) { return a + (b - a) * t; };
    const auto row = [&](int offset) {
      const U word = gather_bytes(codes + offset, index);
      return lerp(lowest(word), lowest(hn::ShiftRight<8>(word)), z);
    };
    return lerp(lerp(row(0), row(kY), y), lerp(row(kX), row(kX + kY), y), x);
  }
}

/// Decides what the codes of samples can (code_range), and lists the rest.
template <LookUp kLookUp>
HWY_NOINLINE void decide_by_codes(const SimdField& f, Events& e) {
  constexpr std::uint32_t kMiddle = 1u << 31;
  e.undecided = 0;
  const F scale = splat(f.scale);
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M open = mask_of(e.open[at / kLanes]);
    const I brick = where(open, as_int(load(&e.brick[at])));
    const auto fraction = [&](const Events::Array<float>& place) {
      const F v = load(&place[at]);
      return v - hn::Floor(v);
    };
    // Indices are signed: counted from the middle, they reach 2^32 codes.
    const U from_middle = as_bits(where(open, as_int(load(&e.sample[at])))) ^ splat_bits(kMiddle);
    const F code = look_up_codes<kLookUp>(f.codes + kMiddle, as_int(from_middle), fraction(e.x),
                                          fraction(e.y), fraction(e.z));
    const F base = gather(f.code_scales, brick + brick);
    const F step = gather(f.code_scales + 1, brick + brick);
    const F mu = load(&e.mu[at]), slack = splat(kCodeSlack);
    const M real = hn::And(open, hn::Lt(mu, scale * (base + (code - slack) * step)));
    e.real[at / kLanes] |= bits_of(real);
    const M below = hn::Lt(mu, scale * (base + (code + slack) * step));
    list_undecided(f, e, at, hn::And(hn::AndNot(real, open), below));
  }
}

/// Notes the times of the first events of Events::which, in fields that move.
inline void note_times(const SimdField& f, FlightMemory& m, std::size_t n) {
  if (f.time_field == 0) return;
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t event = m.events.which[k];
    m.events.time[event] = m.flying[f.time_field][m.events.source[event]];
  }
}

/// Finds the samples of the first events of Events::which of a field that moves: Events::at, from
/// where what is there came. Nothing came from outside the support.
inline HWY_NOINLINE void find_moved_samples(const SimdField& f, FlightMemory& m, std::size_t n) {
  Events& e = m.events;
  note_times(f, m, n);
  trace_back(*f.moving,
             {e.x.data(), e.y.data(), e.z.data(), e.time.data(), e.at_rest[0].data(),
              e.at_rest[1].data(), e.at_rest[2].data()},
             {e.which.data(), n});
  for (std::size_t at = 0; at < n; at += kLanes) {
    const I which = where(first(n - at), as_int(load(&e.which[at])));
    M inside = first(n - at);
    F place[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const F low = splat(f.low[int(axis)]), high = splat(f.high[int(axis)]);
      const F own = gather(e.at_rest[axis].data(), which);
      inside = hn::And(inside, hn::And(hn::Ge(own, low), hn::Le(own, high)));
      place[axis] = hn::Min(hn::Max(own, low), high);
    }
    const Place p(f.bounds, place[0], place[1], place[2]);
    const I brick = as_int(gather(f.bounds.brick.data(), p.leaf(f.bounds)));
    const I own = select(inside, brick, splat_int(int(kZeroBrick)));
    store(as_bits(CellInLeaf(p).samples(f, own)), &e.at[at]);
    for (std::size_t k = at; k < std::min(at + kLanes, n); ++k) prefetch_samples(f, e.at[k]);
  }
}

/// Where look-ups of an event lie in their cell: its place, or what was moved there.
HWY_INLINE const Events::Array<float>& looked_up(const SimdField& f, const Events& e,
                                                 std::size_t axis) {
  if (f.moving != nullptr) return e.at_rest[axis];
  return axis == 0 ? e.x : axis == 1 ? e.y : e.z;
}

/// Density at the chosen events of a register of them all, whose samples were fetched.
template <LookUp kLookUp>
HWY_INLINE F density_at_event(const SimdField& f, const Events& e, std::size_t at, M on) {
  if (f.one_by_one != nullptr) return load(&e.density[at]);
  const auto fraction = [&](std::size_t axis) {
    const F v = load(&looked_up(f, e, axis)[at]);
    return v - hn::Floor(v);
  };
  return look_up<kLookUp>(f, on, where(on, as_int(load(&e.sample[at]))), fraction(0), fraction(1),
                          fraction(2));
}

/// Decides the rest.
template <LookUp kLookUp>
HWY_NOINLINE void decide_by_look_ups(const SimdField& f, Events& e) {
  const F scale = splat(f.scale);
  for (std::size_t at = 0; at < e.undecided; at += kLanes) {
    const M on = first(e.undecided - at);
    const I which = where(on, as_int(load(&e.which[at])));
    const I index = where(on, as_int(load(&e.at[at])));
    const auto fraction = [&](std::size_t axis) {
      const F v = gather(looked_up(f, e, axis).data(), which);
      return v - hn::Floor(v);
    };
    const F rho = look_up<kLookUp>(f, on, index, fraction(0), fraction(1), fraction(2));
    const M real = hn::And(on, hn::Lt(gather(e.mu.data(), which), scale * rho));
    for (std::uint32_t lanes = bits_of(real); lanes != 0; lanes &= lanes - 1) {
      const std::uint32_t event = e.which[at + std::size_t(std::countr_zero(lanes))];
      e.real[event / kLanes] |= 1u << (event % kLanes);
    }
  }
}

/// Looks up the first events of Events::which, lane by lane.
inline void look_up_events(const SimdField& f, FlightMemory& m, std::size_t n) {
  Events& e = m.events;
  const std::span<const std::uint32_t> which{e.which.data(), n};
  note_times(f, m, n);
  detail::look_up_one_by_one(*f.one_by_one, e.x.data(), e.y.data(), e.z.data(), e.time.data(),
                             e.brick.data(), which, e.density.data());
}

/// Decides the rest, lane by lane.
inline HWY_NOINLINE void decide_one_by_one(const SimdField& f, FlightMemory& m) {
  Events& e = m.events;
  look_up_events(f, m, e.undecided);
  for (std::size_t k = 0; k < e.undecided; ++k) {
    const std::uint32_t event = e.which[k];
    const bool real = e.mu[event] < f.scale * e.density[k];
    e.real[event / kLanes] |= std::uint32_t(real) << (event % kLanes);
  }
}

/// Finds out which events are real collisions: the bits of Events::real.
HWY_INLINE void decide(const SimdField& f, FlightMemory& m) {
  decide_by_bounds(f, m);
  if (f.codes == nullptr) {
    decide_by_micro_bounds(f, m.events);
  } else if (f.look_up == LookUp::nearest) {
    decide_by_codes<LookUp::nearest>(f, m.events);
  } else {
    decide_by_codes<LookUp::trilinear>(f, m.events);
  }
  if (f.moving != nullptr) find_moved_samples(f, m, m.events.undecided);
  if (f.one_by_one != nullptr) {
    decide_one_by_one(f, m);
  } else if (f.look_up == LookUp::nearest) {
    decide_by_look_ups<LookUp::nearest>(f, m.events);
  } else {
    decide_by_look_ups<LookUp::trilinear>(f, m.events);
  }
}

/// Where every event's samples are, which are fetched, and its majorant, in Events::mu: for those
/// who look all of them up. Of fields without lanes their densities instead.
inline HWY_NOINLINE void fetch_samples(const SimdField& f, FlightMemory& m) {
  Events& e = m.events;
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at);
    const Place p(f.bounds, load(&e.x[at]), load(&e.y[at]), load(&e.z[at]));
    store(majorant(gather(f.bounds.word.data(), where(on, p.cube))), &e.mu[at]);
    const I brick = as_int(gather(f.bounds.brick.data(), where(on, p.leaf(f.bounds))));
    store(as_bits(CellInLeaf(p).samples(f, brick)), &e.sample[at]);
    store(as_bits(brick), &e.brick[at]);
    store(hn::Iota(kU, std::uint32_t(at)), &e.which[at]);
    if (f.one_by_one != nullptr) continue;
    const std::size_t end = std::min(at + kLanes, e.n);
    for (std::size_t k = at; k < end; ++k) prefetch_samples(f, e.sample[k]);
  }
  if (f.moving != nullptr) {
    find_moved_samples(f, m, e.n);
    std::copy_n(e.at.data(), e.n, e.sample.data());
  } else if (f.one_by_one != nullptr) {
    look_up_events(f, m, e.n);
  }
}

/// The shares of the majorant that extinctions are at the events of a register, whose samples were
/// fetched. Rounding may lift mu_t above the majorant, and may carry an event across a face, into
/// an empty cube: there both are 0.
template <LookUp kLookUp>
HWY_INLINE F share_of_majorant(const SimdField& f, const Events& e, std::size_t at, M on) {
  const F mu = splat(f.scale) * density_at_event<kLookUp>(f, e, at, on);
  const F majorant = load(&e.mu[at]), share = hn::Min(mu / majorant, splat(1));
  return select(hn::Gt(majorant, splat(0)), share, splat(0));
}

/// The probabilities with which rays pass them, for ratio tracking (THEORY.md, T3.3).
template <LookUp kLookUp>
HWY_INLINE F passing(const SimdField& f, const Events& e, std::size_t at, M on) {
  return splat(1) - share_of_majorant<kLookUp>(f, e, at, on);
}

/// Events of a register on their way to a queue: their places, and the rays they were.
struct RaysInFlight {
  F x, y, z, dx, dy, dz;
  U id;
  I source;

  HWY_INLINE RaysInFlight(const FlightMemory& m, std::size_t at, M on) {
    const Events& e = m.events;
    const Records& q = m.flying;
    x = load(&e.x[at]), y = load(&e.y[at]), z = load(&e.z[at]);
    source = where(on, as_int(load(&e.source[at])));
    dx = gather(q[kDX], source), dy = gather(q[kDY], source), dz = gather(q[kDZ], source);
    id = gather(q.bits(kId), source);
  }

  /// Writes the chosen ones behind the last record of `to`, whose number stays.
  HWY_INLINE void put(M chosen, const Random& rng, Records& to) const {
    const std::size_t n = to.n;
    pack(chosen, x, to[kX] + n), pack(chosen, y, to[kY] + n), pack(chosen, z, to[kZ] + n);
    pack(chosen, dx, to[kDX] + n), pack(chosen, dy, to[kDY] + n), pack(chosen, dz, to[kDZ] + n);
    pack(chosen, id, to.bits(kId) + n);
    pack(chosen, rng.s0, to.bits(kRng0) + n), pack(chosen, rng.s1, to.bits(kRng1) + n);
  }
};

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
