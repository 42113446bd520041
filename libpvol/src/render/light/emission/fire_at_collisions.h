// Fires whose light is scored at collisions, leaf by leaf.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pvol/volume/emitter.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// The leaves of a volume's fire in which paths collide wherever it emits, and often enough: there
/// a collision brings emission over extinction, and flights need no look-ups along their lines
/// (THEORY.md, T5.11). Refers to the volume.
class FireAtCollisions {
 public:
  /// Of the leaves in which it brings a luminance of up to `most` (collision_limit.h). None where
  /// the two fields have no lattice in common, are not interpolated alike, or move.
  FireAtCollisions(const Volume& volume, double most);

  /// Whether there are such leaves.
  [[nodiscard]] bool holds_any() const { return holds_any_; }
  /// The fire's octree without them: what is left for lines.
  [[nodiscard]] const Octree& lines() const { return lines_; }

  /// What a collision there brings, in cells of the density: radiance emitted per unit of optical
  /// depth; 0 in other leaves.
  [[nodiscard]] Rgb source(Vec3d cells) const;

  // For those who look these up in lanes:
  [[nodiscard]] const Emitter& fire() const { return *volume_.fire; }
  [[nodiscard]] const Affine& cells_to_fire() const { return cells_to_fire_; }
  [[nodiscard]] const Affine& cells_to_color() const { return cells_to_color_; }
  /// By brick of the fire's field, whether it is of such leaves, as 1, or 0.
  [[nodiscard]] std::span<const std::uint32_t> holds() const { return holds_; }

 private:
  const Volume& volume_;
  Affine cells_to_fire_, cells_to_color_;
  std::vector<std::uint32_t> holds_;
  bool holds_any_ = false;
  Octree lines_;
};

}  // namespace pvol::detail
