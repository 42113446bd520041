// Emitted power by place, to sample directions towards what shines.
#pragma once

#include <span>

#include "math/philox.h"
#include "pvol/math/box.h"
#include "render/light/emission/box_densities.h"
#include "render/light/emission/emission_source.h"

namespace pvol::detail {

struct LitCube;  // of the octree, with its power

/// At most kMost boxes around all places where a field emits, the smaller the more power is there,
/// in cells, so that all places of a field share them. A box is chosen in proportion to its weight
/// (SeenBoxes), and a point in it evenly. The density of directions follows exactly, whatever the
/// powers: they need not be (THEORY.md, T5.12).
/// Based on: Simon, Hanika, Zirr, Dachsbacher. Line integration for rendering heterogeneous
/// emissive volumes. 2017; Villemin, Hery. Practical illumination from flames. 2013.
class PowerBoxes {
 public:
  static constexpr std::size_t kMost = 128;

  /// Of a source that is not empty; estimates powers by a few points of each leaf.
  explicit PowerBoxes(const EmissionSource& source);

  /// Whether all is dark; the rest is for what is not.
  [[nodiscard]] bool dark() const { return boxes_.size() == 0; }
  /// Around all boxes.
  [[nodiscard]] const Box& bounds() const { return bounds_; }
  /// Of all boxes: a cell of luminance 1 a world unit has 1.
  [[nodiscard]] double power() const { return power_; }

  /// A point, as a place sees the boxes; all in cells.
  [[nodiscard]] Vec3d sample(Vec3d place, Rng& rng) const;
  /// A point in cells in proportion to the power, about.
  [[nodiscard]] Vec3d sample(Rng& rng) const;

  /// Density of the directions from the origin of a ray in cells to its samples, per steradian of a
  /// world in which the ray's t is length and a cell has this volume.
  [[nodiscard]] double pdf(const Ray& cells, double cell_volume) const;

 private:
  Box bounds_{};
  double power_ = 0;
  SeenBoxes boxes_;  ///< about the middle of the bounds

  void fill(std::span<const LitCube> cubes);
  [[nodiscard]] Vec3d point_in(std::span<const float> weights, Rng& rng) const;
};

}  // namespace pvol::detail
