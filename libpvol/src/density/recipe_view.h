// The parts of a recipe that decide its density in a box: what sampling and bounding descend with.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "density/noise_kernels.h"
#include "pvol/density/recipe.h"

namespace pvol::detail {

struct SolidView {
  const Solid* solid = nullptr;
  BodyView body;
};

/// Refers to the recipe and must not outlive it.
struct RecipeView {
  const Recipe* recipe = nullptr;
  Interval displacement;  ///< all that displacements may add to the depth, anywhere
  BodyView cloud;         ///< min(max of the forms, min of the cuts)
  std::vector<SolidView> solids;
  Box support;  ///< where there may be any density: far away ranges alone are loose
};

[[nodiscard]] RecipeView view(const Recipe& recipe);

/// The same to the last bit as that of the recipe, where p lies in the box at hand.
[[nodiscard]] double density(const RecipeView& view, Vec3d p);

/// A place, and a view that holds there.
struct RecipePoint {
  const RecipeView* view;
  Vec3d at;
};

/// What `densities` works with, to be kept from call to call.
struct RecipeScratch {
  NoisePoints noise;
  std::vector<double> strength;                ///< of the noise at its points
  std::vector<std::uint32_t> of;               ///< numbers of the points of the noise
  std::vector<double> depth, modulation, rho;  ///< at all points
  std::vector<std::uint32_t> open;             ///< those where noise decides
};

/// density() at all points, of one recipe, as floats.
void densities(std::span<const RecipePoint> points, RecipeScratch& scratch, float* rho);

/// The view without what decides nothing in the box, and the range of the density there.
struct NarrowedRecipe {
  RecipeView view;
  Interval density;
};
[[nodiscard]] NarrowedRecipe narrow(const RecipeView& view, const Box& box);

[[nodiscard]] inline bool is_constant(Interval a) { return a.lo == a.hi; }

/// All that a sum of noises may be, anywhere.
[[nodiscard]] Interval total(const std::vector<MaskedNoise>& noises);

/// Where sample (i, j, k) lies.
[[nodiscard]] inline Vec3d place(const Recipe& recipe, Vec3i at) {
  return Vec3d(at) * recipe.voxel;
}

}  // namespace pvol::detail
