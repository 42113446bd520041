// Fields that emit light, made ready for rays.
#pragma once

#include <optional>

#include "pvol/volume/fire.h"
#include "pvol/volume/value_field.h"

namespace pvol {

/// A fire with its fields, which have places of their own: they may reach beyond the density, or
/// there may be none.
struct Emitter {
  Fire fire{};
  VolumeField field{};  ///< octree: bounds of the mapped values; walks stop at leaves
  std::optional<VolumeField> color_by{};  ///< where another field says the colour
};

/// Makes a fire ready, placed by object_to_world after the grids' own maps; color_by is null where
/// colours take no other field. Look-ups are trilinear. Throws Error for a fire or a placement out
/// of range, for bounds that do not hold, and for a map of 0 to something else.
[[nodiscard]] Emitter make_emitter(const Fire& fire, const BoundedGrid& field,
                                   const BoundedGrid* color_by, const Affine& object_to_world);

/// Radiance per world unit that is emitted at a place of the world.
[[nodiscard]] Rgb emission_at(const Emitter& emitter, Vec3d world);

}  // namespace pvol
