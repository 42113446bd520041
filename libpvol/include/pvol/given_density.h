// Densities that come with their bounds, for the C API: what readers of files hand over.
#pragma once

#include <functional>
#include <memory>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/pvol.h"
#include "pvol/shell/shell.h"

namespace pvol::detail {

/// A density with bounds that are at hand, as files have them; the grid owns its samples.
struct BoundedDensity {
  VoxelGrid grid;
  Pyramid pyramid;
  std::shared_ptr<const Shell> shell;
  std::shared_ptr<const LeafMicroBounds> micro_bounds;
};

using GetDensity = std::function<std::shared_ptr<const BoundedDensity>()>;

/// Gives a handle of the C API the density that `read` returns, and its place, for the next
/// commit. What it throws becomes the status and the message.
[[nodiscard]] pvol_status set_density(pvol_volume* volume, const GetDensity& read);

}  // namespace pvol::detail
