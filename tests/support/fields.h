// Small density fields with known meaning, for tests.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/rng.h"
#include "pvol/volume/volume.h"

namespace pvol::test {

/// Samples on a box of lattice points, 0 outside, once as a dense array for oracles and once as the
/// grid that the library reads.
struct Field {
  std::string name;
  Vec3i origin, size;          ///< lattice points origin + [0, size)
  std::vector<float> samples;  ///< x slowest
  float largest = 0;
  double sum = 0;
  VoxelGrid grid;

  [[nodiscard]] float at(Vec3i p) const {
    const Vec3i i = p - origin;
    for (int axis = 0; axis < 3; ++axis) {
      if (i[axis] < 0 || i[axis] >= size[axis]) return 0;
    }
    return samples[(std::size_t(i.x) * std::size_t(size.y) + std::size_t(i.y)) *
                       std::size_t(size.z) +
                   std::size_t(i.z)];
  }
};

/// Whether constant blocks of a field become tiles of its grid, and of which edge.
enum class Tiles { none, edge_8, edge_128 };

/// density(p) at each lattice point p of origin + [0, size). The grid is in index space (identity
/// map); with `voxel`, index to world is a scaling by that.
[[nodiscard]] Field make_field(std::string name, Vec3i origin, Vec3i size,
                               const std::function<double(Vec3i)>& density,
                               Tiles tiles = Tiles::none, double voxel = 1);

/// One field of each kind: constant, linear, Gaussian, exponential, checkerboard, nearly empty, of
/// contrast 1e6 within a leaf, one voxel, a sheet, random sparse; tiles of edge 8 and 128; one at
/// (-3, 5, 1000003). Made once; largest sample 1.
[[nodiscard]] const std::vector<Field>& fields();

/// The field of that name among `fields()`.
[[nodiscard]] const Field& field(const std::string& name);

/// A random point within a voxel of a random sample above 0, in index space.
[[nodiscard]] Vec3d random_point_near_density(const Field& field, Rng& rng);

/// A field ready for tracking. The world is the grid's index space unless the field has larger or
/// smaller voxels; without a depth the cost model cuts.
[[nodiscard]] Volume make_test_volume(const Field& field, double extinction,
                                      std::optional<int> depth, Tracker tracker = Tracker::delta,
                                      LookUp look_up = LookUp::trilinear);

}  // namespace pvol::test
