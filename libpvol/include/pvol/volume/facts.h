// Figures about a volume.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "pvol/density/density.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Figures about a volume that tools print at load, because a wrong unit is the commonest mistake.
struct VolumeFacts {
  double largest_extinction = 0;                 ///< per world unit
  double shortest_free_path = 0;                 ///< world units, at the largest extinction
  double mean_optical_thickness[3] = {0, 0, 0};  ///< along the index axes, over columns that hit
  double largest_optical_thickness = 0;          ///< over all those columns
  int depth = 0;                                 ///< largest octree depth at which the walk stops
  std::uint64_t nodes = 0;                       ///< of the tree, those below the cut included
  std::uint64_t terminals = 0;                   ///< at which the walk stops
  std::uint64_t field_bytes = 0;   ///< in memory, of samples and what decides for them
  std::uint64_t octree_bytes = 0;  ///< likewise, of bounds
};

/// At how many places a volume is, or all of them together.
[[nodiscard]] inline std::size_t count_places(const Volume& v) {
  return 1 + v.further_places.size();
}
[[nodiscard]] inline std::size_t count_places(std::span<const Volume> volumes) {
  std::size_t sum = 0;
  for (const Volume& v : volumes) sum += count_places(v);
  return sum;
}

/// From the world to where it would be if the volume's place of this number were its first.
[[nodiscard]] inline Affine to_first_place(const Volume& v, std::size_t place) {
  return place == 0 ? Affine{} : inverse(v.further_places[place - 1]);
}

/// Around all volumes of the world that hold anything, at all their places; empty where none does.
/// Places that move are covered at all times of the shutter.
[[nodiscard]] Box world_box(std::span<const Volume> volumes);
/// The same at the time of the files: a camera that frames them does not follow them.
[[nodiscard]] Box still_world_box(std::span<const Volume> volumes);

/// Around the support of a field of a volume, its density or one of its fire's, at one of the
/// volume's places; of one that moves, at all times of the shutter.
[[nodiscard]] Box world_box(const VolumeField& field, const Volume& volume, std::size_t place);

/// About how many null collisions a ray meets in the thin part of the worst segment.
[[nodiscard]] double worst_null_collisions(const Volume& volume);

/// The largest optical depth along an edge of a cell of the volume, anywhere, or more.
[[nodiscard]] double thickest_cell(const Volume& volume);

/// What all samples of a density come to, whatever its extinction and its place.
struct DensityFacts {
  double largest = 0;  ///< sample
  /// Sums of samples along the index axes: the mean over columns that hit, and the largest.
  std::array<double, 3> mean_column{}, largest_column{};
  Affine index_to_world;
};

/// Looks at all samples once. Those of a recipe are estimates, from kCoarseResolution samples along
/// its longest side.
[[nodiscard]] DensityFacts look_through(const VoxelGrid& grid);
[[nodiscard]] DensityFacts look_through(const Recipe& recipe);
[[nodiscard]] DensityFacts look_through(const Density& density);
inline constexpr int kCoarseResolution = 64;

/// What follows from a density without its bounds.
[[nodiscard]] VolumeFacts describe(const DensityFacts& density, double extinction,
                                   const Affine& object_to_world);
template <class Samples>
[[nodiscard]] VolumeFacts describe(const Samples& density, double extinction,
                                   const Affine& object_to_world) {
  return describe(look_through(density), extinction, object_to_world);
}

/// The same with what the volume's tree and field tell.
[[nodiscard]] VolumeFacts describe(const Volume& volume, VolumeFacts of_density);

}  // namespace pvol
