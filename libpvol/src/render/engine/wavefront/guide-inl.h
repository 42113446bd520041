// Importance in lanes: the table of guide/importance.h.

#if defined(PVOL_LANE_GUIDE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_GUIDE_INL_H
#undef PVOL_LANE_GUIDE_INL_H
#else
#define PVOL_LANE_GUIDE_INL_H
#endif

#include "render/engine/wavefront/medium-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// The rows of cells, which are counted from the dense bounds' low corner.
HWY_INLINE I row_of(const CoarseCells& c, I x, I y, I z) {
  const auto along = [&](I cell, int axis) {
    const I coarse = hn::ShiftRightSame(cell - splat_int(DenseBounds::kBorder), c.shift);
    return hn::Min(hn::Max(coarse - splat_int(c.low[axis]), splat_int(0)), splat_int(c.last[axis]));
  };
  const I cube =
      (along(x, 0) * splat_int(c.size.y) + along(y, 1)) * splat_int(c.size.z) + along(z, 2);
  return as_int(gather(c.rows.data(), cube));
}

/// The importance of directions at this 1 - cos to the axis, linear between nodes of the row.
HWY_INLINE F importance_of(const Importance& importance, I row, F one_minus_cosine) {
  const float* const nodes = importance.rows().front().at.data();
  const F x = hn::Sqrt(splat(0.5f) * one_minus_cosine) * splat(float(kDirectionNodes - 1));
  const I node = hn::Min(to_int(x), splat_int(kDirectionNodes - 2));
  const I at = row * splat_int(kDirectionNodes) + node;
  const F a = gather(nodes, at), b = gather(nodes + 1, at);
  return hn::MulAdd(b - a, x - to_float(node), a);
}

/// Towards the light that is strongest there.
HWY_INLINE V axis_of(const Importance& importance, I row) {
  const LightAxes& axes = importance.axes();
  if (axes.is_one()) return splat(axes.of(0));
  const float* const x = &axes.by_row.front().x;
  const I at = row * splat_int(3);
  return {gather(x, at), gather(x + 1, at), gather(x + 2, at)};
}

/// Whether paths are turned towards the axis there.
HWY_INLINE M turns(const Importance& importance, I row) {
  const float* const nodes = importance.rows().front().at.data();
  const I at = row * splat_int(kDirectionNodes);
  return hn::Gt(gather(nodes, at), splat(2) * gather(nodes + (kDirectionNodes - 1), at));
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
