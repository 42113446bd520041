// What fires emit where their fields have these values, in lanes: the bits of emission().

#if defined(PVOL_LANE_EMISSION_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_EMISSION_INL_H
#undef PVOL_LANE_EMISSION_INL_H
#else
#define PVOL_LANE_EMISSION_INL_H
#endif

#include "pvol/volume/fire.h"
#include "volume/simd/map-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Of a fire that is a black body, in the chosen lanes.
inline HWY_NOINLINE V emission_one_by_one(const Fire& fire, F value, F color, M on) {
  alignas(64) float values[kLanes], colors[kLanes], emitted[3][kLanes] = {};
  store(value, values), store(color, colors);
  for (std::uint32_t lanes = bits_of(on); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    const Rgb e = emission(fire, values[k], colors[k]);
    for (std::size_t c = 0; c < 3; ++c) emitted[c][k] = e[int(c)];
  }
  return {load(emitted[0]), load(emitted[1]), load(emitted[2])};
}

/// Radiance per world unit in the chosen lanes.
HWY_INLINE V emission_in_lanes(const Fire& fire, F value, F color, M on) {
  if (fire.kelvin) return emission_one_by_one(fire, value, color, on);
  const auto times_intensity = [&](auto v) { return splat_double(fire.intensity) * v; };
  const F strength = in_doubles(times_intensity, value_in_lanes(fire.map, value, on));
  const auto channel = [&](int c) {
    const F e = splat(fire.color[c]) * strength;
    if (fire.colors.empty()) return e;
    return e * value_in_lanes(fire.colors.channels[std::size_t(c)], color, on);
  };
  return {channel(0), channel(1), channel(2)};
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
