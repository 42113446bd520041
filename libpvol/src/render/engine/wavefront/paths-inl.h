// Paths of a register at their collisions, and single ones of a queue.

#if defined(PVOL_LANE_PATHS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_PATHS_INL_H
#undef PVOL_LANE_PATHS_INL_H
#else
#define PVOL_LANE_PATHS_INL_H
#endif

#include "render/engine/wavefront/events-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A place of a record: in cells of the volume, and in the world.
[[nodiscard]] inline Vec3d cells_at(const Records& q, std::size_t at, std::size_t field = kX) {
  const Vec3d place{double(q[field][at]), double(q[field + 1][at]), double(q[field + 2][at])};
  return place - Vec3d(DenseBounds::kBorder);
}
[[nodiscard]] inline Vec3d world_place(const WavefrontScene& s, const Records& q, std::size_t at,
                                       std::size_t field = kX) {
  return s.volume.cells_to_world.point(cells_at(q, at, field));
}
[[nodiscard]] inline Vec3f direction_at(const Records& q, std::size_t at) {
  return {q[kDX][at], q[kDY][at], q[kDZ][at]};
}

/// The weight of a record of paths that have as many channels.
template <class ComponentKind>
[[nodiscard]] Rgb weight_at(const Records& q, std::size_t at) {
  constexpr bool kGrey = ComponentKind::kWeights == 1;
  return {q[kW0][at], q[kGrey ? kW0 : kW1][at], q[kGrey ? kW0 : kW2][at]};
}

/// Paths at their collisions.
template <class ComponentKind>
struct Paths {
  M alive;
  F x, y, z;
  V from;  ///< direction of the flight
  F w[ComponentKind::kWeights];
  Random rng;
  U id;
  I component;
  I row;               ///< of the importance
  U ray;               ///< through many volumes
  F time;              ///< of those within an instance, where records have times
  F pixel = splat(1);  ///< importance of theirs

  HWY_INLINE Paths(const Records& q, std::size_t at)
      : alive(first(q.n - at)),
        x(load(q[kX] + at)),
        y(load(q[kY] + at)),
        z(load(q[kZ] + at)),
        from{load(q[kDX] + at), load(q[kDY] + at), load(q[kDZ] + at)},
        rng{load(q.bits(kRng0) + at), load(q.bits(kRng1) + at)},
        id(load(q.bits(kId) + at)),
        component(splat_int(0)),
        row(splat_int(0)),
        ray(load(q.bits(kRay) + at)),
        time(load(q[kTime] + at)) {
    for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) w[c] = load(q[kW0 + c] + at);
  }

  HWY_INLINE F largest() const {
    F most = hn::Abs(w[0]);
    for (std::size_t c = 1; c < ComponentKind::kWeights; ++c) most = hn::Max(most, hn::Abs(w[c]));
    return most;
  }
  HWY_INLINE void scale(M chosen, F factor) {
    for (F& v : w) v = select(chosen, v * factor, v);
  }

  /// That of the sizes of the weights.
  HWY_INLINE F luminance() const {
    const auto part = [&](float coefficient, std::size_t c) {
      return splat(coefficient) * hn::Abs(w[ComponentKind::kWeights == 1 ? 0 : c]);
    };
    return part(0.2126f, 0) + part(0.7152f, 1) + part(0.0722f, 2);
  }

  HWY_INLINE void put_place(M chosen, Records& to, std::size_t field = kX) const {
    pack(chosen, x, to[field] + to.n), pack(chosen, y, to[field + 1] + to.n);
    pack(chosen, z, to[field + 2] + to.n);
  }
  HWY_INLINE void put_random(M chosen, const Random& r, Records& to) const {
    pack(chosen, r.s0, to.bits(kRng0) + to.n), pack(chosen, r.s1, to.bits(kRng1) + to.n);
  }
};

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
