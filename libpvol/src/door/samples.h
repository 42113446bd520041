// A field's samples as the C door is given them.
#pragma once

#include <memory>
#include <variant>

#include "pvol/given_density.h"

namespace pvol::detail {

/// What the next commit is to read; nothing: what it has read before.
struct FieldSamples {
  struct None {};  ///< without samples
  struct Same {};  ///< those of the last commit
  std::variant<None, Same, pvol_array, pvol_bricks, pvol_leaves,
               std::shared_ptr<const BoundedDensity>>
      from = None{};
  Affine index_to_world{};
};

/// Reads them. Throws Error for what is no density, and Cancelled where a function gives up.
[[nodiscard]] VoxelGrid read_samples(const pvol_array& array);
[[nodiscard]] VoxelGrid read_samples(const pvol_bricks& bricks);
[[nodiscard]] VoxelGrid read_samples(const pvol_leaves& leaves);

/// A commit that somebody cancelled.
struct Cancelled {};

}  // namespace pvol::detail
