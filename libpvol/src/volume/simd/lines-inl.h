// Optical depths of straight lines by look-ups at points spread over them, a point in each lane.

#if defined(PVOL_LANE_LINES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_LINES_INL_H
#undef PVOL_LANE_LINES_INL_H
#else
#define PVOL_LANE_LINES_INL_H
#endif

#include <algorithm>
#include <cmath>

#include "volume/simd/decide-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A line within the box of the support.
struct Line {
  Vec3f from, way;  ///< where it begins, and from there to its end, in cells as records have them
  float length;     ///< in the world
};

/// Whether optical depths of lines through a field are found in lanes. One whose rays fly one by
/// one has no dense bounds.
[[nodiscard]] inline bool has_lines(const SimdField& f, const VolumeField& field) {
  return field.motion == nullptr && !f.bounds.brick.empty();
}

/// Points in the box of the support.
struct LinePoints {
  F x, y, z;
  I brick;
  M solid;  ///< with density

  HWY_INLINE LinePoints(const SimdField& f, const Line& line, F t, M on) {
    const auto along = [&](int axis) {
      const F at = hn::MulAdd(splat(line.way[axis]), t, splat(line.from[axis]));
      return hn::Min(hn::Max(at, splat(f.low[axis])), splat(f.high[axis]));
    };
    x = along(0), y = along(1), z = along(2);
    const I leaf = where(on, Place(f.bounds, x, y, z).leaf(f.bounds));
    const I found = as_int(gather(f.bounds.brick.data(), leaf));
    solid = hn::And(on, mask(hn::Ne(found, splat_int(int(kZeroBrick)))));
    brick = where(solid, found);
  }

  /// What look-ups compute there; elsewhere 0.
  template <LookUp kLookUp>
  [[nodiscard]] HWY_INLINE F density(const SimdField& f) const {
    if (f.one_by_one != nullptr) return density_one_by_one(*f.one_by_one);
    const auto in_cell = [](F v) { return v - hn::Floor(v); };
    const I samples = where(solid, CellInLeaf(Place(f.bounds, x, y, z)).samples(f, brick));
    const F value = look_up<kLookUp>(f, solid, samples, in_cell(x), in_cell(y), in_cell(z));
    return hn::IfThenElseZero(solid, value);
  }

 private:
  [[nodiscard]] HWY_NOINLINE F density_one_by_one(const VolumeField& field) const {
    alignas(64) float at[3][kLanes], found[kLanes], all[kLanes] = {};
    alignas(64) std::uint32_t bricks[kLanes];
    std::uint32_t which[kLanes];
    std::size_t n = 0;
    store(x, at[0]), store(y, at[1]), store(z, at[2]), store(as_bits(brick), bricks);
    for (std::uint32_t lanes = bits_of(solid); lanes != 0; lanes &= lanes - 1)
      which[n++] = std::uint32_t(std::countr_zero(lanes));
    look_up_one_by_one(field, at[0], at[1], at[2], nullptr, bricks, {which, n}, found);
    for (std::size_t k = 0; k < n; ++k) all[which[k]] = found[k];
    return load(all);
  }
};

/// How many points a line has.
struct PointCount {
  int of_leaf;  ///< for each leaf's edge on its way
  int least;
};

/// Points spread evenly over a line, one in each of as many parts of it, at the positions u + k phi
/// modulo 1 within the parts, phi being the golden ratio.
struct SpreadPoints {
  std::uint32_t n;  ///< of them
  std::uint32_t u;  ///< in units of 2^-32

  SpreadPoints(const Line& line, PointCount points, Rng& rng) {
    const float pieces = length(line.way) * float(points.of_leaf) / float(kLeafEdge);
    n = std::uint32_t(std::max(float(points.least), std::ceil(pieces)));
    u = std::uint32_t(rng.block().lo);
  }

  /// Where on the way a register of them lie, from number k on, in [0, 1].
  [[nodiscard]] HWY_INLINE F from(std::uint32_t k) const {
    constexpr std::uint32_t kGolden = 0x9e3779b9;
    const U number = hn::Iota(kU, k);
    const U within = hn::ShiftRight<8>(splat_bits(u) + number * splat_bits(kGolden));
    const F t = hn::MulAdd(to_float(as_int(within)), splat(0x1p-24f), to_float(as_int(number)));
    return t * splat(1 / float(n));
  }
};

/// The sum of floats that are spread over registers as over one of kMostLanes: in one order,
/// whatever the width of lanes.
class EvenSum {
 public:
  EvenSum() {
    for (F& part : parts_) part = splat(0);
  }
  /// Adds a register; `k` is the number of its first float.
  HWY_INLINE void add(std::uint32_t k, F v) {
    F& part = parts_[k / kLanes % (kMostLanes / kLanes)];
    part = part + v;
  }
  [[nodiscard]] HWY_INLINE float value() const {
    alignas(64) float all[kMostLanes];
    for (std::size_t i = 0; i < kMostLanes / kLanes; ++i) store(parts_[i], all + i * kLanes);
    float sum = 0;
    for (const float v : all) sum += v;
    return sum;
  }

 private:
  F parts_[kMostLanes / kLanes];
};

/// The integral of mu_t along a line, right on average (THEORY.md, T5.11).
template <LookUp kLookUp>
HWY_NOINLINE float optical_depth(const SimdField& f, const Line& line, PointCount points,
                                 Rng& rng) {
  const SpreadPoints all(line, points, rng);
  EvenSum densities;
  for (std::uint32_t k = 0; k < all.n; k += kLanes) {
    const LinePoints p(f, line, all.from(k), first(all.n - k));
    if (!hn::AllFalse(kF, p.solid)) densities.add(k, p.density<kLookUp>(f));
  }
  return densities.value() * f.scale * line.length / float(all.n);
}

HWY_INLINE float optical_depth(const SimdField& f, const Line& line, PointCount points, Rng& rng) {
  if (f.look_up == LookUp::nearest) return optical_depth<LookUp::nearest>(f, line, points, rng);
  return optical_depth<LookUp::trilinear>(f, line, points, rng);
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
