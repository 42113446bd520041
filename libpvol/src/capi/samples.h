// A field's samples as the C API is given them.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include "pvol/given_density.h"

namespace pvol::detail {

/// Lattice points lo <= p < hi.
struct LatticeBox {
  Vec3l lo, hi;
};
inline constexpr LatticeBox kEverywhere{Vec3l(std::numeric_limits<std::int64_t>::min() / 4),
                                        Vec3l(std::numeric_limits<std::int64_t>::max() / 4)};

/// What the next commit is to read; nothing: what it has read before.
struct FieldSamples {
  struct None {};  ///< without samples
  struct Same {};  ///< those of the last commit
  std::variant<None, Same, pvol_array, pvol_bricks, pvol_leaves,
               std::shared_ptr<const BoundedDensity>>
      from = None{};
  std::vector<LatticeBox> changed{};  ///< where they differ from before; none: anywhere
  Affine index_to_world{};
  bool shared = false;  ///< look-ups read them where they are
};

/// Throws Error where what is to be read, or the function that fills it, is null.
void require_samples(const pvol_array& array);
void require_samples(const pvol_bricks& bricks);
void require_samples(const pvol_leaves& leaves);

/// Called with the share of some work that is done, which rises from 0 to 1, by one thread at a
/// time; throws Cancelled where the work is to end.
using Progress = std::function<void(double done)>;

/// Reads those in a box. Throws Error for what is no density, and Cancelled where a function gives
/// up or `progress` says so.
[[nodiscard]] VoxelGrid read_samples(const pvol_array& array, const LatticeBox& box,
                                     const Progress& progress);
[[nodiscard]] VoxelGrid read_samples(const pvol_bricks& bricks, const LatticeBox& box,
                                     const Progress& progress);
[[nodiscard]] VoxelGrid read_samples(const pvol_leaves& leaves, const LatticeBox& box,
                                     const Progress& progress);

/// The array as look-ups can read it where it is. Throws Error where it does not hold floats at
/// their places.
[[nodiscard]] DenseArray shared_array(const pvol_array& array);

/// A commit that somebody cancelled.
struct Cancelled {};

}  // namespace pvol::detail
