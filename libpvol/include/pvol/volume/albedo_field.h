// Fields that vary the albedo of a volume, made ready for rays.
#pragma once

#include <optional>

#include "pvol/density/color_grid.h"
#include "pvol/field/vector_bricks.h"
#include "pvol/volume/albedo_map.h"
#include "pvol/volume/value_field.h"

namespace pvol {

/// The colour in [0, 1] by which albedos are multiplied, at each place: of a grid of numbers or of
/// colours, trilinear, with a place of its own (THEORY.md, T5.14).
struct AlbedoField {
  AlbedoMap map{};
  std::optional<VolumeField> values{};  ///< of a grid of numbers; else:
  VectorBricks colors{};    ///< red, green, blue, and 1; all 0 at samples that say no colour
  Affine world_to_cells{};  ///< of the volume's first place, to cells of either
  Rgb largest{1.0f};        ///< at least the colours wherever there is density, by channel
};

/// Of a grid of numbers, placed by object_to_world after its own map; outside of it they are 0, and
/// the colour is that of 0. Throws what make_value_field throws, and Error for a map out of range.
[[nodiscard]] AlbedoField make_albedo_field(const AlbedoMap& map, const BoundedGrid& numbers,
                                            const Affine& object_to_world);

/// Of a grid of colours. Of the eight samples around a place those that say no colour are left out;
/// where none does, the colour is white: the albedo is the component's own. `density` is looked up
/// trilinearly or by its nearest sample, and makes `largest` tight; null where it is not known.
/// Throws Error for a placement out of range, for a map, which goes with numbers, and for a box of
/// more than 2^24 leaves.
[[nodiscard]] AlbedoField make_albedo_field(const AlbedoMap& map, const ColorGrid& colors,
                                            const VoxelGrid* density,
                                            const Affine& object_to_world);

/// In cells of the field.
[[nodiscard]] Rgb color_in(const AlbedoField& field, Vec3d cells);

/// At a place of the world of the volume's first place.
[[nodiscard]] inline Rgb color_at(const AlbedoField& field, Vec3d world) {
  return color_in(field, field.world_to_cells.point(world));
}

/// At least the albedo of any component and channel, anywhere in the volume.
[[nodiscard]] float largest_albedo(const Volume& volume);

}  // namespace pvol
