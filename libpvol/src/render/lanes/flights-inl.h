// The flights stage: rays move from leaf to leaf until they use up their optical depth or leave.

#if defined(PVOL_LANE_FLIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_FLIGHTS_INL_H
#undef PVOL_LANE_FLIGHTS_INL_H
#else
#define PVOL_LANE_FLIGHTS_INL_H
#endif

#include "render/lanes/lane_math-inl.h"
#include "render/lanes/lane_memory.h"
#include "render/lanes/lane_scene.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// The cells of places, and the index of their leaf among the dense bounds.
struct Place {
  I x, y, z, leaf;

  HWY_INLINE Place(const DenseBounds& b, F px, F py, F pz)
      : x(to_int(px)), y(to_int(py)), z(to_int(pz)) {
    const I columns = hn::ShiftRight<3>(x) * splat_int(b.size.y) + hn::ShiftRight<3>(y);
    leaf = columns * splat_int(b.size.z) + hn::ShiftRight<3>(z);
  }
};

HWY_INLINE F majorant(U word) { return as_float(word & splat_bits(~DenseBounds::kShareBits)); }
HWY_INLINE F minorant_share(U word) {
  return to_float(as_int(word & splat_bits(DenseBounds::kShareBits))) * splat(0x1p-12f);
}

/// Steps in cells per world length for the directions of the slice, and their reciprocals.
HWY_INLINE void aim(const LaneScene& s, LaneMemory& m) {
  const VolumeSetup& v = s.volume;
  const Records& q = m.flying;
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    const F x = load(q[kDX] + at), y = load(q[kDY] + at), z = load(q[kDZ] + at);
    for (int axis = 0; axis < 3; ++axis) {
      const F step = hn::MulAdd(x, splat(v.cells_x[axis]),
                                hn::MulAdd(y, splat(v.cells_y[axis]), z * splat(v.cells_z[axis])));
      // The reciprocal of 0 is large, not infinite.
      const F least = hn::Max(hn::Abs(step), splat(0x1p-120f));
      store(step, m.step[std::size_t(axis)].data() + at);
      store(splat(1) / hn::CopySign(least, step), m.inverse[std::size_t(axis)].data() + at);
    }
  }
}

/// Adds to the counts of samples, one lane at a time: where counts are asked for.
HWY_NOINLINE void count_each(LaneMemory& m, const Records& q, const std::uint32_t* sources,
                             std::uint32_t lanes, PixelCounter counter) {
  for (; lanes != 0; lanes &= lanes - 1) {
    const std::uint32_t id = q.bits(kId)[sources[std::countr_zero(lanes)]];
    ++m.slots.counts[slot_of(id)][std::size_t(counter)];
  }
}

/// Rays in flight, one a lane.
template <bool kLimited>
struct Flying {
  F x, y, z, sx, sy, sz, ix, iy, iz, depth, left;
  U source;

  /// Moves the lanes that live to the front, and rays from `at` on behind them.
  HWY_INLINE void refill(const LaneMemory& m, M live, std::size_t busy, std::size_t at) {
    const M old = first(busy);
    const std::size_t from = at - busy;
    const auto next = [&](F& v, const float* records) {
      v = select(old, compress(live, v), load(records + from));
    };
    const Records& q = m.flying;
    next(x, q[kX]), next(y, q[kY]), next(z, q[kZ]);
    next(sx, m.step[0].data()), next(sy, m.step[1].data()), next(sz, m.step[2].data());
    next(ix, m.inverse[0].data()), next(iy, m.inverse[1].data()), next(iz, m.inverse[2].data());
    next(depth, q[kDepth]);
    if constexpr (kLimited) next(left, q[kLeft]);
    source = select(old, compress(live, source), hn::Iota(kU, std::uint32_t(from)));
  }

  HWY_INLINE void put_ended(M ended, Events& e) const {
    pack(ended, x, e.x.data() + e.n), pack(ended, y, e.y.data() + e.n);
    pack(ended, z, e.z.data() + e.n);
    if constexpr (kLimited) pack(ended, left, e.left.data() + e.n);
    pack(ended, source, e.source.data() + e.n);
    e.n += count(ended);
  }
};

/// The index of the face ahead of a cube, as a place a little beyond it, so that the step into the
/// next cube needs no epsilon, which would stick where it is below the spacing of floats.
HWY_INLINE F face_ahead(I cell, I low_bits, M downward) {
  const I low = hn::AndNot(low_bits, cell), high = (cell | low_bits) + splat_int(1);
  const I face = hn::BitCast(kI, to_float(select(downward, low, high)));
  return hn::BitCast(kF, face - where(downward, splat_int(1)));
}

/// Flies the slice to its end; fills the events and those that are gone.
template <bool kLimited>
HWY_NOINLINE void fly(const LaneScene& s, LaneMemory& m, Tally& tally) {
  aim(s, m);
  const DenseBounds& bounds = s.bounds;
  const std::uint32_t* const words = bounds.word.data();
  const std::size_t rays = m.flying.n;
  constexpr std::size_t kIdle = kLanes * 3 / 8;  // lanes at which a refill pays
  Events& e = m.events;
  e.n = e.gone = 0;
  Flying<kLimited> r{};
  std::size_t at = 0;
  M live = first(0), ended = first(0);
  for (;;) {
    const std::size_t busy = count(live);
    if (busy + kIdle <= kLanes || busy == 0) {
      r.put_ended(ended, e);
      ended = first(0);
      if (at < rays) {
        r.refill(m, live, busy, at);
        const std::size_t fresh = std::min(kLanes - busy, rays - at);
        at += fresh;
        live = first(busy + fresh);
      } else if (busy == 0) {
        break;
      }
    }
    // One cube for every ray that lives.
    const Place p(bounds, r.x, r.y, r.z);
    const I word = as_int(gather(words, where(live, p.leaf)));
    const M solid = mask(hn::Gt(word, splat_int(DenseBounds::kFirstSolid - 1)));
    const M outside = mask(hn::Eq(word, splat_int(DenseBounds::kOutside)));
    const F hi = majorant(as_bits(word));  // 0 in empty cubes
    const I log2 = select(solid, splat_int(3), word);
    const I low_bits = hn::Not(hn::Shl(splat_int(-1), log2));
    const F fx = face_ahead(p.x, low_bits, hn::Lt(r.ix, splat(0)));
    const F fy = face_ahead(p.y, low_bits, hn::Lt(r.iy, splat(0)));
    const F fz = face_ahead(p.z, low_bits, hn::Lt(r.iz, splat(0)));
    const F tx = (fx - r.x) * r.ix, ty = (fy - r.y) * r.iy, tz = (fz - r.z) * r.iz;
    F t = hn::Min(tx, hn::Min(ty, tz));
    if constexpr (kLimited) t = hn::Min(t, r.left);
    const F tau = hi * t;
    const M inside = hn::AndNot(outside, live);
    const M hit = hn::And(inside, hn::And(solid, hn::Lt(r.depth, tau)));
    const F go = select(hit, r.depth / hi, t);
    r.depth = r.depth - tau;
    const M moves = inside, passes = hn::AndNot(hit, inside);
    r.x = select(moves, hn::MulAdd(r.sx, go, r.x), r.x);
    r.y = select(moves, hn::MulAdd(r.sy, go, r.y), r.y);
    r.z = select(moves, hn::MulAdd(r.sz, go, r.z), r.z);
    r.x = select(hn::And(passes, hn::Le(tx, t)), fx, r.x);
    r.y = select(hn::And(passes, hn::Le(ty, t)), fy, r.y);
    r.z = select(hn::And(passes, hn::Le(tz, t)), fz, r.z);
    M leaves = hn::And(outside, live);
    if constexpr (kLimited) {
      r.left = select(moves, r.left - go, r.left);
      leaves = hn::Or(leaves, hn::And(passes, hn::Le(r.left, splat(0))));
    }
    if (s.count) {
      const M entered = hn::And(inside, solid);
      tally.segments += count(entered);
      alignas(64) std::uint32_t sources[kLanes];
      store(r.source, sources);
      count_each(m, m.flying, sources, bits_of(entered), PixelCounter::segments);
    }
    pack(leaves, r.source, e.gone_source.data() + e.gone);
    e.gone += count(leaves);
    ended = hn::Or(ended, hit);
    live = hn::AndNot(hn::Or(leaves, hit), live);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
