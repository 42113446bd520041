// How far it is from places in a volume to all else that rays may meet.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/path/instances.h"
#include "render/path/volume_setup.h"
#include "render/scene/surface/surfaces.h"

namespace pvol::detail {

/// Radii of balls around places in instances: a ray that begins at such a place meets nothing but
/// the instance's volume and thin ones around it within that length of the world, before it leaves
/// the volume's box. They are lower bounds, each for all of a cell of a grid over the box.
class FreeRadii {
 public:
  /// An instance whose box reaches into that of a much denser one. All those around one have at
  /// most a tenth of its largest extinction together.
  struct Thin {
    std::uint32_t instance;
    float majorant;  ///< of its extinction, per world length
  };
  /// Of one instance. Places are in its cells, as records have them.
  struct Grid {
    Affine to_world{};  ///< from cells from the octree's origin
    Vec3f low{}, scale{};
    Vec3i size{};  ///< 0: no radii are known, and rays are kept in the world
    /// Of its radii: that of cell (x, y, z) is number (x * size.y + y) * size.z + z from there.
    std::uint32_t first = 0;
    std::uint32_t first_thin = 0, thin_ones = 0;
    float majorant = 0;  ///< of all thin ones together

    [[nodiscard]] bool is_endless() const { return size == Vec3i(1); }
  };

  /// None.
  FreeRadii() = default;
  /// Those of instances that stand still, and whose flights lanes serve; `surfaces` may be null.
  /// Without `may_be_thin` no volume counts as thin.
  FreeRadii(std::span<const VolumeSetup> volumes, const Instances& instances,
            const Surfaces* surfaces, bool may_be_thin);

  [[nodiscard]] bool any() const { return !grids_.empty(); }
  /// Whether some radii of the instance are not 0.
  [[nodiscard]] bool known(std::uint32_t instance) const {
    return instance < grids_.size() && grids_[instance].size.x > 0;
  }
  [[nodiscard]] const Grid& of(std::uint32_t instance) const { return grids_[instance]; }
  [[nodiscard]] const float* radii(const Grid& grid) const { return radii_.data() + grid.first; }
  /// One of the thin ones around an instance, by their majorants and a uniform number.
  [[nodiscard]] const Thin& draw_thin(const Grid& grid, float u) const;
  /// 0 where none is known; 2^100 where nothing else reaches the box.
  [[nodiscard]] float at(std::uint32_t instance, Vec3f place) const;

 private:
  std::vector<Grid> grids_;  ///< by instance; empty: no radii are known
  std::vector<float> radii_;
  std::vector<Thin> thin_;

  struct Around;
  /// Lists the thin ones around an instance.
  void find_thin(const Around& around, std::uint32_t instance);
  /// Finds an instance's radii, by a grid of so many cells along its longest axis.
  void find_radii(const Around& around, std::uint32_t instance, int along);
};

}  // namespace pvol::detail
