// Procedural clouds: free forms with noise on their surface, sampled into a sparse grid.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pvol/density/noise.h"
#include "pvol/density/profile.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/form/body.h"
#include "pvol/math/box.h"
#include "pvol/math/interval.h"

namespace pvol {

/// amplitude * clamp(mask(p), 0, 1) * fbm(p).
struct MaskedNoise {
  Fbm noise;
  double amplitude = 0;
  Quadric mask{{}, {}, {}, /*constant=*/1};  ///< by default everywhere
  friend bool operator==(const MaskedNoise&, const MaskedNoise&) = default;
};

/// A dense region of its own, which may stand in a cloud:
///   solid(p) = density * clamp(body(p) / edge, 0, 1).
struct Solid {
  Body body;
  double density = 1;  ///< > 0
  double edge = 0.02;  ///< depth over which the density rises to that, world units, > 0
  friend bool operator==(const Solid&, const Solid&) = default;
};

/// A density field in closed form, in world space:
///   depth(p) = min(max_i form_i(p), min_j cut_j(p)) + sum_k displacement_k(p)
///   cloud(p) = density * profile(depth(p) / edge) * max(0, 1 + sum_k modulation_k(p))
///   rho(p)   = max(cloud(p), max_s solid_s(p)).
/// So forms unite and cuts intersect, and each may be a tree of its own. Values of bodies count as
/// distances from the surface: scale them (k * body) to a gradient of about 1 world unit per world
/// unit there; a cut of gradient s moves 1/s as far under the noise and ramps 1/s as wide. Where a
/// displacement is positive the cloud's surface moves outward, inward where it is negative.
struct Recipe {
  std::string name = "density";  ///< of the grid
  double voxel = 0.01;           ///< distance of samples, world units, > 0
  double density = 1;            ///< rho deep inside, > 0
  double edge = 0.02;            ///< depth over which rho rises to that, world units, > 0
  Profile profile;
  std::vector<Body> forms;  ///< at least one, or a solid
  std::vector<Body> cuts;
  std::vector<MaskedNoise> displacements;  ///< amplitudes in world units
  std::vector<MaskedNoise> modulations;    ///< amplitudes without unit
  std::vector<Solid> solids;
  friend bool operator==(const Recipe&, const Recipe&) = default;
};

/// Most samples along a side of a grid: 4096^3 is 256 GiB where all of it is cloud.
inline constexpr int kLargestResolution = 4096;

/// Most levels of parts in a body, and of perturbations in a form.
inline constexpr int kDeepestTree = 32;

/// Throws Error, naming the value, where something is out of the range stated above or not finite,
/// where trees are deeper than kDeepestTree, where bodies do not bound the cloud, and where it has
/// more than kLargestResolution samples along a side or lies too far from the origin, 2^30 samples
/// or 2^48 cells of a noise.
void validate(const Recipe& recipe);

/// rho(p), for a valid recipe, as are those below.
[[nodiscard]] double density(const Recipe& recipe, Vec3d world);

/// Holds density(p), as computed, for every p of the finite box; equal ends where it is certainly
/// constant (T8.1).
[[nodiscard]] Interval density_range(const Recipe& recipe, const Box& world);

/// A box outside which the density is 0, as if the noise took its largest value everywhere; empty
/// for a recipe without a cloud.
[[nodiscard]] Box support(const Recipe& recipe);

/// The voxel size at which the longest side of the support has `resolution` samples.
[[nodiscard]] double voxel_for(const Recipe& recipe, int resolution);

/// Samples of the density at the points voxel * (i, j, k), without bricks of zeros; cubes of one
/// value become tiles. Pruned by density_range, and still the values are exactly those of
/// density(); the same for any number of threads, of which it uses those of the caller's task
/// arena. Throws Error as validate() does.
[[nodiscard]] VoxelGrid make_grid(const Recipe& recipe);

}  // namespace pvol
