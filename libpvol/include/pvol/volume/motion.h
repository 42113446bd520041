// Densities that move while the shutter is open.
#pragma once

#include "pvol/bounds/pyramid.h"
#include "pvol/field/displacements.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/shutter.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// What moves a field, a volume's density or its fire: at time t, in frames, there is at x what the
/// file has at x - t d(x), with the displacement d of a frame at x itself (THEORY.md, T1.6).
/// Octree, support and box of such a density bound it at all times from the files' to any while the
/// shutter is open; look-ups that know of no time find it as the files have it.
struct Motion {
  Displacements displacements;  ///< of a frame, in cells of the density
  Affine cells_to_lattice;      ///< from cells of the octree to those of the displacements
  Shutter shutter;
  double longest = 0;       ///< way from the files' place along an axis, in cells
  double still_extent = 0;  ///< of the support along its longest axis, in cells
};

/// Velocities of a file and how to read them.
struct Movement {
  const VelocityGrid& velocity;  ///< in the space of the density's own map: placements turn it, too
  double seconds = 1.0 / 24;     ///< that a frame lasts, times any factor on velocities
  Shutter shutter;
};

/// The same volume in motion. `pyramid` is the one that it was made with, `index_to_object` its
/// density's own map. Shells and micro-bounds, which bound what stands still, are dropped. Its fire
/// is made to move by itself. While the shutter is closed it only learns its velocities; a volume
/// that nothing moves stays as it is. Throws Error where displacements are out of range
/// (make_displacements) and, if the shutter opens, for recipes with procedural look-ups, for
/// homogenised or scaled bounds and bounds that do not hold, and for the tracker regular.
[[nodiscard]] Volume make_moving(Volume still, const Pyramid& pyramid,
                                 const Affine& index_to_object, const Movement& movement,
                                 const VolumeOptions& options);

/// The same fire in motion, made of this grid and its bounds and placed by `object_to_world`. One
/// that nothing moves, or has no time for it, stays as it is. Throws Error where displacements are
/// out of range.
[[nodiscard]] Emitter make_moving(Emitter still, const BoundedGrid& field,
                                  const Affine& object_to_world, const Movement& movement);

/// Of the volume's density or, where that stands still, of its fire; null: of neither.
[[nodiscard]] inline const Motion* motion_of(const Volume& v) {
  if (v.density.motion || !v.fire) return v.density.motion.get();
  return v.fire->field.motion.get();
}

/// How far a volume moves in a frame, in the world, at a place of its density's cells: by its
/// velocities, and as a whole at this time, in frames (T1.6, T1.7). `place` is the number of its
/// place, `world_to_cells` that place at this time. 0 where nothing is known of it.
[[nodiscard]] Vec3d velocity_at(const Volume& volume, std::size_t place,
                                const Affine& world_to_cells, Vec3d cells, double frames);

/// Bounds of a moving density, as a pyramid whose leaves lie on the lattice of the still one: over
/// each leaf, of what the still density is anywhere in the box that its density came from at any
/// time of the shutter and at 0. Links of the still field say where samples are, so that boxes that
/// lie partly in a leaf see their own samples only; not for tricubic look-ups.
[[nodiscard]] Pyramid sweep_bounds(const Pyramid& pyramid, const VolumeField& still,
                                   const Displacements& displacements, const Shutter& shutter);

}  // namespace pvol
