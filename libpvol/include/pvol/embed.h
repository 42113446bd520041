// Extinction fields for other renderers: a cloud from memory, then free flights and transmittance
// along rays of the world, one call a ray, from any thread. Batches are in pvol/volume/batch.h, other
// trackers and counts in pvol/volume/counted_rays.h, segments, trackers of your own and paths that
// go on where they collided in pvol/trackers.h, whole pictures in pvol/render/render.h.
//
//   // Once: density on a lattice of 0.1 world units, mu_t = 4 x density.
//   const pvol::VoxelGrid grid =
//       pvol::make_grid({.values = data, .size = {nx, ny, nz}}, pvol::scaling(pvol::Vec3d(0.1)));
//   const pvol::Volume cloud = pvol::make_volume(grid, {.extinction = 4});
//
//   // For each ray, anywhere: where it collides, and how much of the light comes through.
//   pvol::Rng rng(seed, pixel, sample);
//   const pvol::Flight flight = pvol::sample_flight(cloud, {origin, direction}, t_max, rng);
//   const float shadow = pvol::sample_transmittance(cloud, {place, to_light}, distance, rng);
//
// Units. Lengths are in world units, mu_t is per world unit. t is the distance from the ray's
// origin: directions of any length are normalised on entry, so that the place at t is o + t d.
//
// Threads and lifetime. A Volume has copies of all it needs: the grid may go. Any number of threads
// may use it at once, each with an Rng of its own. A copy of it shares the samples.
//
// Random numbers. An Rng is 24 bytes and made in no time: key one by (seed, pixel, sample) for each
// path and pass it on, or make one for each call by two 64-bit numbers from a generator of yours,
// Rng(yours(), yours(), 0). Equal keys give equal numbers on any thread and any machine.
//
// Errors. Making a grid or a volume throws Error (error.h) for input that is no density, no map or
// out of range. A ray that is not finite or has no direction throws Error too, since it would cast
// a shadow that nobody finds; a ray that misses is no error. Nothing else here throws.
//
// Several volumes may overlap: the shortest of their free flights is that of their sum, and their
// transmittances multiply.
#pragma once

#include "pvol/density/voxel_grid.h"
#include "pvol/error.h"
#include "pvol/math/box.h"
#include "pvol/math/rng.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/medium.h"
#include "pvol/volume/volume.h"

namespace pvol {

struct Recipe;  // density/recipe.h

// 1. Making a volume: of a grid by make_grid (density/voxel_grid.h), from an array or a callback.

/// Bounds the grid's density and makes it ready for tracking. Of the medium, tracking needs
/// `extinction` alone; options.object_to_world is applied after the grid's map, and
/// volume.density.world_box bounds the density. Throws Error where the grid is not as VoxelGrid says,
/// the map singular, the medium or the options out of range, the extinction too large for a float,
/// or the placement so far from the origin that positions lose more than 1/1000 of a voxel.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Medium& medium,
                                 const VolumeOptions& options = {});

/// The same for a recipe (density/recipe.h), whose look-ups are procedural, whatever the options'
/// own interpolation: bounds in closed form, no samples.
[[nodiscard]] Volume make_volume(const Recipe& recipe, const Medium& medium,
                                 const VolumeOptions& options = {});

// 2. One call a ray.

/// The distance to the next collision, at most t_max, or none: `collided` is false. Analog, so that
/// its weight is 1; the density of t is mu_t(t) exp(-int_0^t mu_t).
[[nodiscard]] Flight sample_flight(const Volume& volume, const Ray& ray, double t_max, Rng& rng);

/// An unbiased estimate of the transmittance up to t_max, in [0, 1] give or take rounding. `ratio`
/// suits most rays. `analog`, which is 0 or 1, costs less in thick clouds; choose_transmittance
/// (volume/estimators.h) says once for a volume what suits it. Throws Error for `automatic`.
[[nodiscard]] float sample_transmittance(const Volume& volume, const Ray& ray, double t_max,
                                         Rng& rng, Transmittance estimator = Transmittance::ratio);

/// exp(-int mu_t) up to t_max in closed form, cell by cell, exact but for the rounding of positions
/// to 2^-24 cells a step (THEORY.md, T1.3). Throws Error for volumes without a closed form:
/// tricubic, procedural, mapped and moving ones.
[[nodiscard]] double exact_transmittance(const Volume& volume, const Ray& ray, double t_max);

/// rho and mu_t at a point of the world; 0 outside the cloud, and where the point is not finite.
/// The samples are found anew at each; along a ray, a walk and a field know them (trackers.h).
[[nodiscard]] float density_at(const Volume& volume, Vec3d world);
[[nodiscard]] float extinction_at(const Volume& volume, Vec3d world);

}  // namespace pvol
