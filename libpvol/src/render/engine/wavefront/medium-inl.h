// Components and their phase functions in lanes.

#if defined(PVOL_LANE_MATTER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_MATTER_INL_H
#undef PVOL_LANE_MATTER_INL_H
#else
#define PVOL_LANE_MATTER_INL_H
#endif

#include "render/engine/wavefront/phase_batch.h"
#include "render/engine/wavefront/wavefront_scene.h"
#include "volume/simd/simd_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A direction in each lane, with the phase function's density for it.
struct Scattered {
  V direction;
  F pdf;
};

HWY_INLINE Lobe lobe_of(const HenyeyGreenstein& hg) {
  return {splat(hg.g), splat(hg.one_minus_g), splat(hg.one_minus_g2), splat(hg.axis)};
}

/// The medium of volumes of one component with one lobe and grey albedo.
struct OneLobe {
  static constexpr std::size_t kWeights = 1;  ///< channels of paths' weights
  F albedo;
  Lobe lobe;

  HWY_INLINE OneLobe(const WavefrontScene& s, I)
      : albedo(splat(s.components.albedo[0][0])),
        lobe{splat(s.components.lobes[0].g[0]), splat(s.components.lobes[0].one_minus_g[0]),
             splat(s.components.lobes[0].one_minus_g2[0]), splat(s.components.lobes[0].axis[0])} {}

  static HWY_INLINE I choose(const WavefrontScene&, Random&) { return splat_int(0); }
  HWY_INLINE F albedo_of(std::size_t) const { return albedo; }
  HWY_INLINE F pdf(V from, V to) const {
    return pdf_of_angle(lobe, one_minus_cos(along_axis(lobe, from), to));
  }
  HWY_INLINE Scattered sample(V from, F u, F azimuth) const {
    const F c = one_minus_cos_of_share(lobe, u);
    return {turn(along_axis(lobe, from), c, azimuth), pdf_of_angle(lobe, c)};
  }
};

HWY_INLINE void store_vector(V v, float (*to)[kMostLanes]) {
  store(v.x, to[0]), store(v.y, to[1]), store(v.z, to[2]);
}

/// Any components, with two lobes each, or with any phase functions.
struct AnyComponent {
  static constexpr std::size_t kWeights = 3;
  const ComponentTable& t;
  I number;  ///< of each lane's component

  HWY_INLINE AnyComponent(const WavefrontScene& s, I component)
      : t(s.components), number(component) {}

  static HWY_INLINE I choose(const WavefrontScene& s, Random& rng) {
    const std::vector<float>& up_to = s.components.share_up_to;
    I chosen = splat_int(0);
    if (up_to.size() == 1) return chosen;
    const F u = rng.uniform();
    for (std::size_t k = 0; k + 1 < up_to.size(); ++k) {
      chosen = chosen + where(hn::Ge(u, splat(up_to[k])), splat_int(1));
    }
    return chosen;
  }
  HWY_INLINE F albedo_of(std::size_t channel) const {
    return gather(t.albedo[channel].data(), number);
  }
  HWY_INLINE Lobe lobe(std::size_t k) const {
    const ComponentTable::Lobe& l = t.lobes[k];
    return {gather(l.g.data(), number), gather(l.one_minus_g.data(), number),
            gather(l.one_minus_g2.data(), number), gather(l.axis.data(), number)};
  }
  HWY_INLINE F pdf(V from, V to) const {
    if (!t.one_by_one.empty()) return pdf_one_by_one(from, to);
    const auto of = [&](std::size_t k) {
      const Lobe l = lobe(k);
      return pdf_of_angle(l, one_minus_cos(along_axis(l, from), to));
    };
    const F share = gather(t.lobe_share.data(), number);
    return share * of(0) + (splat(1) - share) * of(1);
  }
  HWY_INLINE Scattered sample(V from, F u, F azimuth) const {
    if (!t.one_by_one.empty()) return sample_one_by_one(from, u, azimuth);
    const F share = gather(t.lobe_share.data(), number);
    const M forward = hn::Lt(u, share);
    const Lobe a = lobe(0), b = lobe(1);
    const auto pick = [&](F x, F y) { return select(forward, x, y); };
    const Lobe l{pick(a.g, b.g), pick(a.one_minus_g, b.one_minus_g),
                 pick(a.one_minus_g2, b.one_minus_g2), pick(a.axis, b.axis)};
    const F rest = pick(u, u - share) / pick(share, splat(1) - share);
    const V d = turn(along_axis(l, from), one_minus_cos_of_share(l, rest), azimuth);
    return {d, pdf(from, d)};
  }

 private:
  HWY_NOINLINE F pdf_one_by_one(V from, V to) const {
    PhaseBatch lanes;
    store(as_bits(number), lanes.component);
    store_vector(from, lanes.from), store_vector(to, lanes.to);
    find_densities(t.one_by_one, kLanes, lanes);
    return load(lanes.pdf);
  }
  HWY_NOINLINE Scattered sample_one_by_one(V from, F u, F azimuth) const {
    PhaseBatch lanes;
    store(as_bits(number), lanes.component);
    store_vector(from, lanes.from);
    store(u, lanes.u), store(azimuth, lanes.azimuth);
    sample_directions(t.one_by_one, kLanes, lanes);
    return {{load(lanes.to[0]), load(lanes.to[1]), load(lanes.to[2])}, load(lanes.pdf)};
  }
};

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
