// Copies the samples of each leaf, with its apron, out of the grid.
#include "pvol/field/brick_field.h"

#include <algorithm>
#include <cstring>

#include "field/link_bricks.h"
#include "math/memory.h"

namespace pvol {
namespace {

/// Keeps copies of the samples (link_bricks.h).
class Copies {
 public:
  Copies(const detail::BlockFinder& blocks, BrickField& field)
      : blocks_(blocks), field_(field), count_(std::size_t(field_samples(field.look_up))) {}

  std::uint32_t extend(std::size_t n) {
    const std::size_t first = field_.bricks();
    const double bytes = double(n) * double(count_) * sizeof(float);
    if (const std::uint64_t free = detail::free_memory(); bytes > double(free)) {
      detail::refuse_memory("the density", bytes, free);
    }
    field_.samples.resize((first + n) * count_);
    return std::uint32_t(first);
  }
  void fill(std::uint32_t b, float value) { std::fill_n(at(b), count_, value); }
  const float* fill(std::uint32_t b, Vec3i origin, float*) {
    detail::gather(blocks_, origin, field_.look_up, at(b));
    return at(b);
  }

 private:
  [[nodiscard]] float* at(std::uint32_t b) {
    return field_.samples.data() + std::size_t(b) * count_;
  }

  const detail::BlockFinder& blocks_;
  BrickField& field_;
  std::size_t count_;
};

}  // namespace

void detail::gather(const BlockFinder& blocks, Vec3i origin, LookUp look_up, float* out) {
  const KernelExtent extent = extent_of(look_up);
  const int edge = field_edge(look_up);
  const auto copy = [&](const BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
    const Vec3i first = to + Vec3i(extent.below);
    for (int i = 0; i < count.x; ++i) {
      for (int j = 0; j < count.y; ++j) {
        float* row = out + ((first.x + i) * edge + first.y + j) * edge + first.z;
        if (b.values) {
          const float* source = b.values + ((from.x + i) * 8 + from.y + j) * 8 + from.z;
          std::memcpy(row, source, std::size_t(count.z) * sizeof(float));
        } else {
          std::fill_n(row, count.z, b.constant);
        }
      }
    }
  };
  for_blocks_in_extent(blocks, origin, extent, copy);
}

FieldWithLinks build_field(const VoxelGrid& grid, const Pyramid& pyramid,
                           const FieldOptions& options) {
  detail::check_support(grid, pyramid, options.look_up);
  FieldWithLinks r;
  if (options.look_up == LookUp::tricubic) r.field.look_up = options.look_up;
  const detail::BlockFinder blocks(grid);
  Copies copies(blocks, r.field);
  detail::link_bricks(blocks, !grid.tiles.empty(), pyramid, options, copies, r);
  return r;
}

}  // namespace pvol
