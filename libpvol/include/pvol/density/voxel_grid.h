// A sparse lattice of density samples in memory: what readers and recipes hand to the library.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pvol/math/affine.h"
#include "pvol/math/names.h"

namespace pvol {

/// Samples along each edge of a brick.
inline constexpr int kBrickEdge = 8;
inline constexpr int kBrickSamples = kBrickEdge * kBrickEdge * kBrickEdge;

/// 8^3 samples at lattice points origin + (i, j, k), 0 <= i, j, k < 8; sample (i, j, k) is
/// values[(i * 8 + j) * 8 + k]. The origin is a multiple of 8 on each axis. Every value is finite
/// and not negative.
struct Brick {
  Vec3i origin;
  const float* values = nullptr;
};

/// edge^3 samples of one value > 0 at origin + [0, edge)^3; the edge is 8, 128 or 4096 and the
/// origin is a multiple of it (the tiles of an OpenVDB 5-4-3 tree). Far too large to expand
/// blindly.
struct Tile {
  Vec3i origin;
  std::int32_t edge = 0;
  float value = 0;
};

/// Density samples rho_ijk >= 0 on the integer lattice; samples in no brick and no tile are 0.
/// Sample (i, j, k) sits at index-space point (i, j, k), as in OpenVDB: the interpolation cells are
/// [i, i+1]^3, and the support of the field reaches one cell beyond the outermost samples.
/// Bricks and tiles are disjoint; their order does not matter.
struct VoxelGrid {
  std::string name = "density";
  Affine index_to_world;
  std::vector<Brick> bricks;
  std::vector<Tile> tiles;
  std::shared_ptr<const void> owner;  ///< keeps `values` of every brick alive
};

/// Samples in an array of the caller's: that of lattice point origin + (i, j, k), 0 <= (i, j, k) <
/// size, is values[dot((i, j, k), stride)]. Only read, and only during a call.
struct DenseArray {
  const float* values = nullptr;
  Vec3i size;
  Vec3i origin{0, 0, 0};
  std::optional<Vec3l> stride{};  ///< without: as in C's values[x][y][z], z fastest; for x fastest
                                  ///< it is (1, size.x, size.x * size.y)
};

/// A sparse copy of the array, without bricks of zeros. Throws Error, naming the sample, where a
/// value is not finite or negative; for a size below 1, an array of no address, lattice points
/// beyond +-2^30, and bricks that need more memory than is free, judged by some of them first.
[[nodiscard]] VoxelGrid make_grid(const DenseArray& array, const Affine& index_to_world = {});

/// Writes the samples of the brick at `origin`, in the order of Brick::values, over zeros.
using FillBrick = std::function<void(Vec3i origin, float* values)>;

/// A grid of what `fill` writes for every brick that holds a lattice point of lo <= p < hi, without
/// bricks of zeros, for densities that no dense array could hold. `fill` is called from several
/// threads at once, and what it throws is passed on. Throws Error as above, and where hi > lo does
/// not hold on each axis.
[[nodiscard]] VoxelGrid make_grid(Vec3i lo, Vec3i hi, const FillBrick& fill,
                                  const Affine& index_to_world = {});

/// How the density at a point is found.
enum class LookUp {
  nearest,
  trilinear,
  tricubic,    ///< the uniform cubic B-spline: C2, and never outside the hull of its 4^3 samples
  procedural,  ///< no samples: a recipe is evaluated at the point
};
[[nodiscard]] constexpr auto names(LookUp) {
  return std::to_array<Named<LookUp>>({
      {LookUp::nearest, "nearest"},
      {LookUp::trilinear, "trilinear"},
      {LookUp::tricubic, "tricubic"},
      {LookUp::procedural, "procedural"},
  });
}
/// Whether a field of such look-ups is a polynomial in each cell, so that optical depths have
/// closed forms.
[[nodiscard]] constexpr bool has_closed_form(LookUp look_up) {
  return look_up == LookUp::nearest || look_up == LookUp::trilinear;
}

/// Along each axis, interpolation in cell i reads the samples i - below .. i + above.
struct KernelExtent {
  int below, above;
};
[[nodiscard]] constexpr KernelExtent extent_of(LookUp look_up) {
  return look_up == LookUp::tricubic ? KernelExtent{1, 2} : KernelExtent{0, 1};
}

/// Sample (i, j, k) by search: slow, for tests and converters.
[[nodiscard]] float sample(const VoxelGrid& grid, Vec3i at);

/// The grid's bricks and tiles in order of their origins (x, then y, then z), so that equal fields
/// are equal in memory and in files.
void sort(VoxelGrid& grid);

/// The grid's bricks and tiles in that order, without those of zeros; the samples stay where they
/// are.
[[nodiscard]] VoxelGrid occupied(const VoxelGrid& grid);

}  // namespace pvol
