// Volumes that nothing else of a scene reaches.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/path/instances.h"
#include "render/path/volume_setup.h"
#include "render/scene/surface/surfaces.h"

namespace pvol::detail {

/// Instances whose boxes neither surfaces nor other instances reach, and which stand still. A ray
/// that begins in one meets nothing but its volume before it leaves the box.
class ApartInstances {
 public:
  /// None.
  ApartInstances() = default;
  /// Those of volumes whose flights lanes serve; `surfaces` may be null.
  ApartInstances(std::span<const VolumeSetup> volumes, const Instances& instances,
                 const Surfaces* surfaces);

  [[nodiscard]] bool hold(std::uint32_t instance) const {
    return instance < apart_.size() && apart_[instance] != 0;
  }
  [[nodiscard]] bool any() const { return !apart_.empty(); }
  /// From the cells of one of them to the world.
  [[nodiscard]] const Affine& to_world(std::uint32_t instance) const { return to_world_[instance]; }

 private:
  std::vector<std::uint8_t> apart_;  ///< by instance; empty: none is
  std::vector<Affine> to_world_;
};

}  // namespace pvol::detail
