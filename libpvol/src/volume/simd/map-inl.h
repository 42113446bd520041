// What maps of a field's values make of them in lanes: the bits that math/field_map.h makes of one
// value.

#if defined(PVOL_LANE_MAP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_MAP_INL_H
#undef PVOL_LANE_MAP_INL_H
#else
#define PVOL_LANE_MAP_INL_H
#endif

#include <bit>
#include <vector>

#include "pvol/math/field_map.h"
#include "volume/simd/simd_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// op(v...) in doubles, rounded to floats.
template <class Op, class... Floats>
HWY_INLINE F in_doubles(const Op& op, Floats... v) {
  constexpr hn::RepartitionToWide<DF> kDoubles;
  constexpr hn::Half<DF> kHalf;
  const auto lower = [&](F x) { return hn::PromoteTo(kDoubles, hn::LowerHalf(kHalf, x)); };
  const auto upper = [&](F x) { return hn::PromoteTo(kDoubles, hn::UpperHalf(kHalf, x)); };
  return hn::Combine(kF, hn::DemoteTo(kHalf, op(upper(v)...)),
                     hn::DemoteTo(kHalf, op(lower(v)...)));
}

/// The same number in each lane of doubles.
HWY_INLINE auto splat_double(double v) { return hn::Set(hn::RepartitionToWide<DF>(), v); }

/// Whether lanes go along a ramp together: straight lines.
HWY_INLINE bool has_lanes(const Ramp& ramp) { return !ramp.smooth; }
HWY_INLINE bool has_lanes(const FieldMap& map) {
  return (map.power == 1 || map.power == 2 || map.power == 3) && has_lanes(map.ramp);
}

/// How many points are before x: each is asked where they are few, else halves of what is left.
HWY_INLINE I count_before(const std::vector<RampPoint>& p, F x) {
  constexpr std::size_t kFew = 16;
  I before = splat_int(0);
  if (p.size() <= kFew) {
    for (const RampPoint& point : p)
      before = before + where(hn::Lt(splat(point.x), x), splat_int(1));
    return before;
  }
  const I end = splat_int(int(p.size()));
  for (int step = int(std::bit_floor(p.size())); step > 0; step /= 2) {
    const I next = before + splat_int(step), last = hn::Min(next, end) - splat_int(1);
    const M less = hn::Lt(gather(&p.front().x, last + last), x);
    before = select(hn::And(less, mask(hn::Lt(next, end + splat_int(1)))), next, before);
  }
  return before;
}

/// value_at(ramp, x) for a ramp of points that has lanes.
inline HWY_NOINLINE F along_ramp(const Ramp& ramp, F x) {
  static_assert(sizeof(RampPoint) == 2 * sizeof(float));
  const std::vector<RampPoint>& p = ramp.points;
  if (p.size() == 1) return splat(p.front().y);
  const I next = count_before(p, x);  // the number of the first point that is not
  const int end = int(p.size());
  const I at = hn::Min(hn::Max(next, splat_int(1)), splat_int(end - 1));
  const auto number = [&](int offset) { return gather(&p.front().x + offset, at + at); };
  const F ax = number(-2), ay = number(-1), bx = number(0), by = number(1);
  const auto line = [](auto x0, auto y0, auto x1, auto y1, auto v) {
    return y0 + (v - x0) / (x1 - x0) * (y1 - y0);
  };
  const F y = in_doubles(line, ax, ay, bx, by, x);
  const F between = hn::Min(hn::Max(y, hn::Min(ay, by)), hn::Max(ay, by));
  const F inside = select(hn::Eq(bx, x), by, between);
  const F above = select(mask(hn::Eq(next, splat_int(end))), splat(p.back().y), inside);
  return select(mask(hn::Eq(next, splat_int(0))), splat(p.front().y), above);
}

/// value_at(map, v) for a map that has lanes.
inline HWY_NOINLINE F map_together(const FieldMap& map, F v) {
  const auto before_power = [&](auto d) {
    const auto x = splat_double(map.scale) * d + splat_double(map.offset);
    if (!map.clamp) return x;
    return hn::Min(hn::Max(x, splat_double((*map.clamp)[0])), splat_double((*map.clamp)[1]));
  };
  F x = in_doubles(before_power, v);
  if (map.power != 1) {
    const auto raise = [&](auto d) { return map.power == 2 ? d * d : d * d * d; };
    x = in_doubles(raise, hn::Max(x, splat(0)));
  }
  return hn::Max(map.ramp.points.empty() ? x : along_ramp(map.ramp, x), splat(0));
}

/// One value after the other, in the chosen lanes.
template <class Change>
HWY_INLINE F change_one_by_one(F v, M on, const Change& change) {
  alignas(64) float all[kLanes];
  store(v, all);
  for (std::uint32_t lanes = bits_of(on); lanes != 0; lanes &= lanes - 1) {
    float& one = all[std::countr_zero(lanes)];
    one = change(one);
  }
  return load(all);
}

/// The values of a ramp, and of a map, in the chosen lanes.
HWY_INLINE F value_in_lanes(const Ramp& ramp, F x, M on) {
  if (!ramp.points.empty() && has_lanes(ramp)) return along_ramp(ramp, x);
  return change_one_by_one(x, on, [&](float one) { return value_at(ramp, one); });
}
HWY_INLINE F value_in_lanes(const FieldMap& map, F v, M on) {
  if (has_lanes(map)) return map_together(map, v);
  return change_one_by_one(v, on, [&](float one) { return value_at(map, one); });
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
