// The stage of scattering: new directions, by the phase function alone or by importance among a few
// (THEORY.md, T5.5).

#if defined(PVOL_LANE_SCATTER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_SCATTER_INL_H
#undef PVOL_LANE_SCATTER_INL_H
#else
#define PVOL_LANE_SCATTER_INL_H
#endif

#include "render/engine/wavefront/collide-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A register of paths to be scattered is put among those that are to fly.
template <class ComponentKind>
HWY_INLINE void launch(const WavefrontScene& s, const Records& q, std::size_t at, M on, V direction,
                       F pdf, F factor, Random& rng, Records& to) {
  const std::size_t n = to.n;
  for (const Field f : {kX, kY, kZ, kId}) store(load(q[f] + at), to[f] + n);
  store(direction.x, to[kDX] + n), store(direction.y, to[kDY] + n), store(direction.z, to[kDZ] + n);
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) {
    const std::size_t f = kW0 + c;
    store(load(q[f] + at) * factor, to[f] + n);
  }
  if (s.weighted) store(pdf, to[kPdf] + n);
  if (s.many) store(load(q.bits(kRay) + at), to.bits(kRay) + n);
  if (s.times) store(load(q[kTime] + at), to[kTime] + n);
  if (s.lines) {
    store(load(q[kX] + at), to[kFromX] + n), store(load(q[kY] + at), to[kFromY] + n);
    store(load(q[kZ] + at), to[kFromZ] + n);
  }
  store(rng.exponential(), to[kDepth] + n);
  store(rng.s0, to.bits(kRng0) + n), store(rng.s1, to.bits(kRng1) + n);
  to.n += count(on);
}

HWY_INLINE V direction_of(const Records& q, std::size_t at) {
  return {load(q[kDX] + at), load(q[kDY] + at), load(q[kDZ] + at)};
}

template <class ComponentKind>
HWY_INLINE ComponentKind component_of(const WavefrontScene& s, const Records& q, std::size_t at,
                                      M on) {
  return ComponentKind(s, ComponentKind::kWeights > 1
                              ? where(on, as_int(load(q.bits(kComponent) + at)))
                              : splat_int(0));
}

template <class ComponentKind>
HWY_NOINLINE void scatter(const WavefrontScene& s, Records& q, Records& to) {
  to.reserve(q.n);
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    const M on = first(q.n - at);
    Random rng{load(q.bits(kRng0) + at), load(q.bits(kRng1) + at)};
    const ComponentKind component = component_of<ComponentKind>(s, q, at, on);
    const F u = rng.uniform(), azimuth = rng.uniform();
    const Scattered d = component.sample(direction_of(q, at), u, azimuth);
    launch<ComponentKind>(s, q, at, on, d.direction, d.pdf, splat(1), rng, to);
  }
  q.n = 0;
}

/// Of two directions from the phase function and one from the axis' lobe, one is chosen in
/// proportion to phase function times importance over the sum of their densities.
template <class ComponentKind>
HWY_NOINLINE void scatter_guided(const WavefrontScene& s, Records& q, Records& to) {
  const Importance& importance = *s.importance();
  const Lobe lobe = lobe_of(importance.lobe());
  to.reserve(q.n);
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    const M on = first(q.n - at);
    Random rng{load(q.bits(kRng0) + at), load(q.bits(kRng1) + at)};
    const ComponentKind component = component_of<ComponentKind>(s, q, at, on);
    const V from = direction_of(q, at);
    const I row = where(on, as_int(load(q.bits(kAux) + at)));
    const V axis = axis_of(importance, row);
    V d[3] = {from, from, from};
    F pdf[3], value[3], weight[3];
    const auto propose = [&](int i, V direction, F p, F from_axis) {
      d[i] = direction;
      pdf[i] = p;
      value[i] = importance_of(importance, row, from_axis);
      weight[i] = value[i] * p / hn::MulAdd(splat(2), p, pdf_of_angle(lobe, from_axis));
    };
    for (int i = 0; i < 2; ++i) {
      const F u = rng.uniform(), azimuth = rng.uniform();
      const Scattered to_d = component.sample(from, u, azimuth);
      propose(i, to_d.direction, to_d.pdf, one_minus_cos(to_d.direction, axis));
    }
    const F c = one_minus_cos_of_share(lobe, rng.uniform());
    const V d2 = turn(axis, c, rng.uniform());
    propose(2, d2, component.pdf(from, d2), c);
    const F sum01 = weight[0] + weight[1], sum = sum01 + weight[2];
    const F u = rng.uniform() * sum;
    const M is0 = hn::Lt(u, weight[0]), is1 = hn::Lt(u, sum01);
    const auto pick = [&](auto a, auto b, auto e) { return select(is0, a, select(is1, b, e)); };
    launch<ComponentKind>(s, q, at, on, pick(d[0], d[1], d[2]), pick(pdf[0], pdf[1], pdf[2]),
                          sum / pick(value[0], value[1], value[2]), rng, to);
  }
  q.n = 0;
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
