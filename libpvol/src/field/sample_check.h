// Whether bounds hold the samples that a field is made of.
#pragma once

#include <cstdint>
#include <mutex>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/field/bounds_excess.h"
#include "pvol/math/box.h"

namespace pvol::detail {

/// The lattice point at the low corner of a node's cube.
[[nodiscard]] inline Vec3i origin_of(const Pyramid& pyramid, std::size_t level,
                                     std::uint64_t code) {
  return Vec3i(pyramid.origin + Vec3l(morton_decode(code)) * (std::int64_t(kLeafEdge) << level));
}

/// Compares bounds with samples and keeps a record of those that do not hold; from any thread.
class SampleCheck {
 public:
  SampleCheck(const Pyramid& pyramid, double most_excess)
      : pyramid_(pyramid), most_excess_(most_excess) {}

  /// Refuses what most_excess does not allow: every picture made with it would be wrong.
  void add(std::size_t level, const PyramidNode& node, float lo, float hi);
  void add(std::size_t level, const PyramidNode& node, const float* samples, int count);
  [[nodiscard]] const BoundsExcess& excess() const { return excess_; }

 private:
  [[nodiscard]] Box cube_of(std::size_t level, const PyramidNode& node) const;
  [[noreturn]] void fail(const Box& cube, const PyramidNode& node, float lo, float hi) const;

  const Pyramid& pyramid_;
  double most_excess_;
  BoundsExcess excess_;
  std::mutex mutex_;
};

/// Refuses density outside the support's box, at which walks end.
void check_support(const VoxelGrid& grid, const Pyramid& pyramid, LookUp look_up);

}  // namespace pvol::detail
