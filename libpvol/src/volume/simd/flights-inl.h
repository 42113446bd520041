// The flights stage: rays move from cube to cube until they use up their optical depth or leave.

#if defined(PVOL_LANE_FLIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_FLIGHTS_INL_H
#undef PVOL_LANE_FLIGHTS_INL_H
#else
#define PVOL_LANE_FLIGHTS_INL_H
#endif

#include "volume/simd/flight_memory.h"
#include "volume/simd/simd_field.h"
#include "volume/simd/simd_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// The cells of places, and the indices of their cubes among the dense bounds.
struct Place {
  I x, y, z, cube;

  HWY_INLINE Place(const DenseBounds& b, F px, F py, F pz)
      : x(to_int(px)), y(to_int(py)), z(to_int(pz)) {
    const auto along = [&](I v) { return hn::ShiftRightSame(v, b.shift); };
    cube = (along(x) * splat_int(b.size.y) + along(y)) * splat_int(b.size.z) + along(z);
  }
  /// Those of their leaves' bricks.
  [[nodiscard]] HWY_INLINE I leaf(const DenseBounds& b) const {
    const I columns = hn::ShiftRight<3>(x) * splat_int(b.leaves.y) + hn::ShiftRight<3>(y);
    return columns * splat_int(b.leaves.z) + hn::ShiftRight<3>(z);
  }
};

HWY_INLINE F majorant(U word) { return as_float(word & splat_bits(~DenseBounds::kShareBits)); }
HWY_INLINE F minorant_share(U word) {
  return to_float(as_int(word & splat_bits(DenseBounds::kShareBits))) * splat(0x1p-12f);
}

/// Steps in cells per world length for the directions of the slice, and their reciprocals.
HWY_INLINE void aim(const SimdField& f, FlightMemory& m) {
  const Records& q = m.flying;
  const auto put = [&](std::size_t at, std::size_t axis, F step) {
    // The reciprocal of 0 is large, not infinite.
    const F least = hn::Max(hn::Abs(step), splat(0x1p-120f));
    store(step, m.step[axis].data() + at);
    store(splat(1) / hn::CopySign(least, step), m.inverse[axis].data() + at);
  };
  if (f.step_field != 0) {
    for (std::size_t at = 0; at < q.n; at += kLanes) {
      for (std::size_t axis = 0; axis < 3; ++axis) put(at, axis, load(q[f.step_field + axis] + at));
    }
    return;
  }
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    const F x = load(q[kDX] + at), y = load(q[kDY] + at), z = load(q[kDZ] + at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int i = int(axis);
      put(at, axis,
          hn::MulAdd(x, splat(f.cells[0][i]),
                     hn::MulAdd(y, splat(f.cells[1][i]), z * splat(f.cells[2][i]))));
    }
  }
}

/// The index of the face ahead of a cube, as a place a little beyond it, so that the step into the
/// next cube needs no epsilon, which would stick where it is below the spacing of floats.
HWY_INLINE F face_ahead(I cell, I low_bits, M downward) {
  const I low = hn::AndNot(low_bits, cell), high = (cell | low_bits) + splat_int(1);
  const I face = hn::BitCast(kI, to_float(select(downward, low, high)));
  return hn::BitCast(kF, face - where(downward, splat_int(1)));
}

/// Rays in flight, one a lane.
template <bool kLimited>
struct Flying {
  F x = splat(0), y = x, z = x, sx = x, sy = x, sz = x, ix = x, iy = x, iz = x, depth = x, left = x;
  U source = splat_bits(0);
  M live = first(0), ended = first(0);  ///< those that fly, and those that used up their depth

  /// Hands out the ended rays and, where enough lanes are idle, takes rays from `at` on behind
  /// those that live, which move to the front. Returns whether any ray flies.
  HWY_INLINE bool refill(FlightMemory& m, std::size_t& at) {
    constexpr std::size_t kIdle = kLanes * 3 / 8;  // lanes at which a refill pays
    const std::size_t busy = count(live);
    if (busy + kIdle > kLanes) return true;
    put_ended(m.events);
    const Records& q = m.flying;
    if (at == q.n) return busy > 0;
    const M old = first(busy);
    const std::size_t from = at - busy;
    const auto next = [&](F& v, const float* records) {
      v = select(old, compress(live, v), load(records + from));
    };
    next(x, q[kX]), next(y, q[kY]), next(z, q[kZ]);
    next(sx, m.step[0].data()), next(sy, m.step[1].data()), next(sz, m.step[2].data());
    next(ix, m.inverse[0].data()), next(iy, m.inverse[1].data()), next(iz, m.inverse[2].data());
    next(depth, q[kDepth]);
    if constexpr (kLimited) next(left, q[kLeft]);
    source = select(old, compress(live, source), hn::Iota(kU, std::uint32_t(from)));
    const std::size_t fresh = std::min(kLanes - busy, q.n - at);
    at += fresh;
    live = first(busy + fresh);
    return true;
  }

  /// Moves every ray that lives through one cube.
  template <class Counts>
  HWY_INLINE void step(const SimdField& f, FlightMemory& m, Counts& counts) {
    const Place p(f.bounds, x, y, z);
    const I word = as_int(gather(f.bounds.word.data(), where(live, p.cube)));
    const M solid = mask(hn::Gt(word, splat_int(DenseBounds::kFirstSolid - 1)));
    const M outside = mask(hn::Eq(word, splat_int(DenseBounds::kOutside)));
    const F hi = majorant(as_bits(word));  // 0 in empty cubes
    const I log2 = select(solid, splat_int(f.bounds.shift), word);
    const I low_bits = hn::Not(hn::Shl(splat_int(-1), log2));
    const F fx = face_ahead(p.x, low_bits, hn::Lt(ix, splat(0)));
    const F fy = face_ahead(p.y, low_bits, hn::Lt(iy, splat(0)));
    const F fz = face_ahead(p.z, low_bits, hn::Lt(iz, splat(0)));
    const F tx = (fx - x) * ix, ty = (fy - y) * iy, tz = (fz - z) * iz;
    F t = hn::Min(tx, hn::Min(ty, tz));
    if constexpr (kLimited) t = hn::Min(t, left);
    const F tau = hi * t;
    const M moves = hn::AndNot(outside, live);
    const M hit = hn::And(moves, hn::And(solid, hn::Lt(depth, tau)));
    const M passes = hn::AndNot(hit, moves);
    const F go = select(hit, depth / hi, t);
    depth = depth - tau;
    x = select(moves, hn::MulAdd(sx, go, x), x);
    y = select(moves, hn::MulAdd(sy, go, y), y);
    z = select(moves, hn::MulAdd(sz, go, z), z);
    x = select(hn::And(passes, hn::Le(tx, t)), fx, x);
    y = select(hn::And(passes, hn::Le(ty, t)), fy, y);
    z = select(hn::And(passes, hn::Le(tz, t)), fz, z);
    M leaves = hn::And(outside, live);
    if constexpr (kLimited) {
      left = select(moves, left - go, left);
      leaves = hn::Or(leaves, hn::And(passes, hn::Le(left, splat(0))));
    }
    if (counts.on()) {
      alignas(64) std::uint32_t sources[kLanes];
      store(source, sources);
      counts.add_segments(sources, bits_of(hn::And(moves, solid)));
    }
    pack(leaves, source, m.events.gone_source.data() + m.events.gone);
    m.events.gone += count(leaves);
    ended = hn::Or(ended, hit);
    live = hn::AndNot(hn::Or(leaves, hit), live);
  }

 private:
  HWY_INLINE void put_ended(Events& e) {
    pack(ended, x, e.x.data() + e.n), pack(ended, y, e.y.data() + e.n);
    pack(ended, z, e.z.data() + e.n);
    if constexpr (kLimited) pack(ended, left, e.left.data() + e.n);
    pack(ended, source, e.source.data() + e.n);
    e.n += count(ended);
    ended = first(0);
  }
};

/// Flies the slice to its end; fills the events and those that are gone. Two registers of rays take
/// turns: a step waits for its bounds for most of its time. `counts` is told of the segments, where
/// it is on.
template <bool kLimited, class Counts>
HWY_NOINLINE void fly(const SimdField& f, FlightMemory& m, Counts& counts) {
  aim(f, m);
  m.events.n = m.events.gone = 0;
  Flying<kLimited> a{}, b{};
  std::size_t at = 0;
  for (;;) {
    const bool flies_a = a.refill(m, at), flies_b = b.refill(m, at);
    if (!flies_a && !flies_b) break;
    a.step(f, m, counts);
    b.step(f, m, counts);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
