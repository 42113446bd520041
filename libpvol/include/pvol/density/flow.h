// How a procedural cloud moves, in closed form.
#pragma once

#include "pvol/density/noise.h"
#include "pvol/density/velocity_grid.h"

namespace pvol {

/// A velocity for each place of the world, in world units per second:
///   v(p) = velocity + spin x (p - centre) + stretch * (p - centre) + turbulence * n(p),
/// where the components of n are independent noises in [-1, 1].
struct Flow {
  Vec3d velocity{};       ///< everywhere
  Vec3d spin{};           ///< radians per second about the axes, against the clock from their tips
  Vec3d stretch{};        ///< growth per second along the axes
  Vec3d centre{};         ///< of spin and stretch
  double turbulence = 0;  ///< world units per second, >= 0
  Fbm noise{};            ///< of the first component; seeds of the others follow its own
  friend bool operator==(const Flow&, const Flow&) = default;
};

/// Throws Error, naming the value, where something is out of range or not finite.
void validate(const Flow& flow);

/// v(p) of a valid flow.
[[nodiscard]] Vec3d velocity_at(const Flow& flow, Vec3d world);

/// Samples of the flow in a box of the world and around it, at least one voxel and half of the
/// box's extent wide, since the density moves only where there is a velocity. Sparse as densities
/// are, without bricks of zeros; the same for any number of threads. Throws Error for an empty box,
/// a voxel that is not above 0, velocities beyond 3.4e38 and more than 512 voxels along a side.
[[nodiscard]] VelocityGrid sample_flow(const Flow& flow, const Box& box, double voxel);

}  // namespace pvol
