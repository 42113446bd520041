// Colours of albedo fields at the places of paths (THEORY.md, T5.14).

#if defined(PVOL_LANE_COLORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_COLORS_INL_H
#undef PVOL_LANE_COLORS_INL_H
#else
#define PVOL_LANE_COLORS_INL_H
#endif

#include "render/engine/wavefront/lights-inl.h"
#include "volume/any_source.h"
#include "volume/cell_look_up.h"
#include "volume/simd/map-inl.h"
#include "volume/simd/values-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Whether lanes look up a field of numbers together.
[[nodiscard]] inline bool has_lanes(const AlbedoField& field, const VolumeField& density) {
  return field.values && density.motion == nullptr && has_values_in_lanes(*field.values);
}

/// The colours that numbers stand for (color_of).
HWY_INLINE void color_values(const AlbedoMap& map, F values, M alive, PathColors& to) {
  const F mapped = value_in_lanes(map.map, values, alive);
  for (std::size_t c = 0; c < 3; ++c) {
    const F color =
        map.colors.empty() ? mapped : value_in_lanes(map.colors.channels[c], mapped, alive);
    store(hn::Min(hn::Max(color, splat(0)), splat(1)), to[c].data());
  }
}

/// Finds the colours at the paths' places, where albedos vary.
template <class ComponentKind>
HWY_NOINLINE void find_colors(const WavefrontScene& s, WavefrontMemory& m,
                              const Paths<ComponentKind>& p) {
  const AlbedoField* const field = s.volume.volume.albedo.get();
  PathColors& to = m.colors;
  if (field == nullptr) {
    for (std::size_t c = 0; c < 3; ++c) store(splat(1), to[c].data());
    return;
  }
  const VolumeField& density = s.volume.volume.density;
  const Affine& to_field = s.volume.cells_to_albedo;
  if (has_lanes(*field, density)) {
    const F values = values_at(*field->values, to_field, p.x, p.y, p.z);
    return color_values(field->map, values, p.alive, to);
  }
  const LanePlaces places(s, m, p);
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    const Vec3d at_rest = place_at_rest(density, places.time(k), places.in_cells(k));
    const Rgb color = color_in(*field, to_field.point(at_rest));
    for (std::size_t c = 0; c < 3; ++c) to[c][k] = color[int(c)];
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
