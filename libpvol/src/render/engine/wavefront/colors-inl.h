// Colours of albedo fields at the places of paths (THEORY.md, T5.14).

#if defined(PVOL_LANE_COLORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_COLORS_INL_H
#undef PVOL_LANE_COLORS_INL_H
#else
#define PVOL_LANE_COLORS_INL_H
#endif

#include "pvol/bounds/leaf_index.h"
#include "render/engine/wavefront/lights-inl.h"
#include "volume/any_source.h"
#include "volume/simd/look_up-inl.h"
#include "volume/simd/map-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Whether lanes look up a field of numbers together: what stands still, has an index of its
/// leaves, and samples that 31 bits number.
[[nodiscard]] inline bool has_lanes(const AlbedoField& field, const VolumeField& density) {
  if (!field.values || density.motion != nullptr) return false;
  const VolumeField& f = *field.values;
  return f.leaves != nullptr && f.bricks().samples.size() >> 31 == 0;
}

/// Cells of the support of a field along an axis of its, and places in them; outside of the support
/// these are not in [0, 1].
struct CellsAlong {
  F cell, in_cell;

  /// Of places (x, y, z) in cells of the density, as records have them, that a map takes there.
  HWY_INLINE CellsAlong(const Affine& map, const Octree& tree, int axis, F x, F y, F z) {
    const Vec3d row = map.m[std::size_t(axis)];
    const auto to_place = [&](auto px, auto py, auto pz) {
      const auto border = splat_double(DenseBounds::kBorder);
      return splat_double(row.x) * (px - border) + splat_double(row.y) * (py - border) +
             splat_double(row.z) * (pz - border) + splat_double(map.t[axis]);
    };
    const auto to_cell = [&](auto place) {
      return hn::Min(hn::Max(hn::Floor(place), splat_double(tree.support_lo[axis])),
                     splat_double(tree.support_hi[axis] - 1));
    };
    cell = in_doubles([&](auto... at) { return to_cell(to_place(at...)); }, x, y, z);
    in_cell = in_doubles(
        [&](auto... at) {
          const auto place = to_place(at...);
          return place - to_cell(place);
        },
        x, y, z);
  }
  [[nodiscard]] HWY_INLINE M inside() const {
    return hn::And(hn::Ge(in_cell, splat(0)), hn::Le(in_cell, splat(1)));
  }
};

/// The values of a field of numbers at places in cells of the density, as records have them.
HWY_INLINE F values_at(const VolumeField& field, const Affine& to_field, F x, F y, F z) {
  const auto along = [&](int axis) { return CellsAlong(to_field, field.octree, axis, x, y, z); };
  const CellsAlong ax = along(0), ay = along(1), az = along(2);
  const I cx = to_int(ax.cell), cy = to_int(ay.cell), cz = to_int(az.cell);
  const LeafIndex& leaves = *field.leaves;
  const auto leaf_of = [](I cell) { return hn::ShiftRight<3>(cell); };
  const I leaf = leaf_of(cx) * splat_int(int(leaves.slab)) +
                 leaf_of(cy) * splat_int(int(leaves.row)) + leaf_of(cz) -
                 splat_int(int(leaves.first));
  const I brick = as_int(gather(leaves.brick.data(), leaf));
  const I sample = CellInLeaf(cx, cy, cz).first_sample(brick);
  const M inside = hn::And(ax.inside(), hn::And(ay.inside(), az.inside()));
  return look_up<LookUp::trilinear>(field.bricks().samples.data(), where(inside, sample),
                                    ax.in_cell, ay.in_cell, az.in_cell);
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
