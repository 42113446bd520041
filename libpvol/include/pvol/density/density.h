// A density, as samples or as a recipe.
#pragma once

#include <memory>
#include <variant>

#include "pvol/density/recipe.h"
#include "pvol/density/voxel_grid.h"

namespace pvol {

/// Samples, or a recipe that is evaluated at each point. A recipe is not null.
using Density = std::variant<VoxelGrid, std::shared_ptr<const Recipe>>;

[[nodiscard]] inline bool is_sampled(const Density& density) {
  return std::holds_alternative<VoxelGrid>(density);
}

/// Where cells lie in the object's space: the map of the samples, or a recipe's voxels.
[[nodiscard]] inline Affine index_to_object(const Density& density) {
  if (const auto* grid = std::get_if<VoxelGrid>(&density)) return grid->index_to_world;
  return scaling(Vec3d(std::get<std::shared_ptr<const Recipe>>(density)->voxel));
}

}  // namespace pvol
