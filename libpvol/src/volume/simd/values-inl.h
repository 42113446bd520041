// Values of fields of samples at places of another field, in lanes: the bits of value_in().

#if defined(PVOL_LANE_VALUES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_VALUES_INL_H
#undef PVOL_LANE_VALUES_INL_H
#else
#define PVOL_LANE_VALUES_INL_H
#endif

#include "pvol/bounds/leaf_index.h"
#include "volume/simd/look_up-inl.h"
#include "volume/simd/map-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

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

/// Where a field that has_values_in_lanes() has its samples at places in cells of the density, as
/// records have them.
struct SamplePlaces {
  M inside;  ///< the field's support
  I brick, sample;
  F x, y, z;  ///< in the cells

  HWY_INLINE SamplePlaces(const VolumeField& field, const Affine& to_field, F px, F py, F pz) {
    const auto along = [&](int axis) {
      return CellsAlong(to_field, field.octree, axis, px, py, pz);
    };
    const CellsAlong ax = along(0), ay = along(1), az = along(2);
    const I cx = to_int(ax.cell), cy = to_int(ay.cell), cz = to_int(az.cell);
    const LeafIndex& leaves = *field.leaves;
    const auto leaf_of = [](I cell) { return hn::ShiftRight<3>(cell); };
    const I leaf = leaf_of(cx) * splat_int(int(leaves.slab)) +
                   leaf_of(cy) * splat_int(int(leaves.row)) + leaf_of(cz) -
                   splat_int(int(leaves.first));
    brick = as_int(gather(leaves.brick.data(), leaf));
    sample = CellInLeaf(cx, cy, cz).first_sample(brick);
    x = ax.in_cell, y = ay.in_cell, z = az.in_cell;
    inside = hn::And(ax.inside(), hn::And(ay.inside(), az.inside()));
  }
  /// The field's values there.
  [[nodiscard]] HWY_INLINE F values(const VolumeField& field) const {
    return look_up<LookUp::trilinear>(field.bricks().samples.data(), where(inside, sample), x, y,
                                      z);
  }
};

/// The values of a field that has_values_in_lanes() at places in cells of the density, as records
/// have them.
HWY_INLINE F values_at(const VolumeField& field, const Affine& to_field, F x, F y, F z) {
  return SamplePlaces(field, to_field, x, y, z).values(field);
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
