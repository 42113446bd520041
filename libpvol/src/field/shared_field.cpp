// Finds where the samples of each leaf are, and copies as few of them as there can be.
#include "pvol/field/shared_field.h"

#include <cstring>
#include <map>
#include <mutex>

#include "density/array_rows.h"
#include "field/brick_samples.h"
#include "field/link_bricks.h"

namespace pvol {
namespace {

constexpr std::array<std::ptrdiff_t, 3> kPacked{kFieldEdge * kFieldEdge, kFieldEdge, 1};

/// Blocks of `count` samples of one value, made on demand and shared.
class ConstantBlocks {
 public:
  ConstantBlocks(SharedField& field, std::size_t count) : field_(field), count_(count) {}

  const float* block(float value) {
    const auto [at, fresh] = index_.try_emplace(value, nullptr);
    if (fresh) at->second = field_.own.emplace_back(count_, value).data();
    return at->second;
  }
  /// That of a value which has one; from any thread.
  [[nodiscard]] const float* known(float value) const { return index_.find(value)->second; }

 private:
  SharedField& field_;
  std::size_t count_;
  std::map<float, const float*> index_;
};

/// Keeps places in leaves (link_bricks.h).
class InLeaves {
 public:
  InLeaves(const VoxelGrid& grid, const detail::BlockFinder& blocks, SharedField& field)
      : blocks_(blocks), field_(field), constants_(field, kBrickSamples) {
    (void)constants_.block(0);
    for (const Tile& t : grid.tiles) (void)constants_.block(t.value);
  }

  std::uint32_t extend(std::size_t n) {
    const std::size_t first = field_.leaves.size();
    field_.leaves.resize(first + n);
    return std::uint32_t(first);
  }
  void fill(std::uint32_t b, float value) { field_.leaves[b].block.fill(constants_.block(value)); }
  const float* fill(std::uint32_t b, Vec3i origin, float* scratch) {
    for (std::size_t k = 0; k < 8; ++k) {
      const Vec3i above(int(k >> 2), int(k >> 1 & 1), int(k & 1));
      const detail::BlockSource from = blocks_.find(origin + above * kBrickEdge);
      field_.leaves[b].block[k] = from.values ? from.values : constants_.known(from.constant);
    }
    return detail::samples_of(field_, b, scratch);
  }

 private:
  const detail::BlockFinder& blocks_;
  SharedField& field_;
  ConstantBlocks constants_;
};

/// Keeps places in an array, and copies of what is at its faces (link_bricks.h).
class InArray {
 public:
  InArray(const DenseArray& array, const detail::BlockFinder& blocks, SharedField& field)
      : array_(array),
        stride_(detail::stride_of(array)),
        blocks_(blocks),
        field_(field),
        constants_(field, kFieldSamples) {}

  std::uint32_t extend(std::size_t n) {
    const std::size_t first = field_.windows.size();
    field_.windows.resize(first + n);
    return std::uint32_t(first);
  }
  void fill(std::uint32_t b, float value) {
    field_.windows[b] = {constants_.block(value), kPacked};
  }
  const float* fill(std::uint32_t b, Vec3i origin, float* scratch) {
    const Vec3i first = origin - array_.origin, last = first + Vec3i(kFieldEdge - 1);
    if (min_component(first) >= 0 && max(last, array_.size - Vec3i(1)) == array_.size - Vec3i(1)) {
      field_.windows[b] = {array_.values + dot(Vec3l(first), stride_),
                           {stride_.x, stride_.y, stride_.z}};
      return detail::samples_of(field_, b, scratch);
    }
    float* const copy = make_block();
    detail::gather(blocks_, origin, LookUp::trilinear, copy);
    field_.windows[b] = {copy, kPacked};
    return copy;
  }

 private:
  float* make_block() {
    const std::scoped_lock lock(mutex_);
    return field_.own.emplace_back(kFieldSamples).data();
  }

  const DenseArray& array_;
  Vec3l stride_;
  const detail::BlockFinder& blocks_;
  SharedField& field_;
  ConstantBlocks constants_;
  std::mutex mutex_;
};

}  // namespace

std::uint64_t SharedField::bytes() const {
  std::uint64_t sum = leaves.size() * sizeof(LeafSamples) + windows.size() * sizeof(ArraySamples);
  for (const auto& block : own) sum += block.size() * sizeof(float);
  return sum + shared_bytes;
}

const float* detail::samples_of(const SharedField& field, std::uint32_t b, float* scratch) {
  float* out = scratch;
  if (field.in_leaves()) {
    const LeafSamples& leaf = field.leaves[b];
    for (int x = 0; x < kFieldEdge; ++x) {
      for (int y = 0; y < kFieldEdge; ++y, out += kFieldEdge) {
        const auto block = std::size_t(4 * (x >> 3) + 2 * (y >> 3));
        const int row = ((x & 7) * kBrickEdge + (y & 7)) * kBrickEdge;
        std::memcpy(out, leaf.block[block] + row, kBrickEdge * sizeof(float));
        out[kBrickEdge] = leaf.block[block + 1][row];
      }
    }
    return scratch;
  }
  const ArraySamples& window = field.windows[b];
  const auto [sx, sy, sz] = window.stride;
  for (int x = 0; x < kFieldEdge; ++x) {
    for (int y = 0; y < kFieldEdge; ++y) {
      const float* const row = window.first + x * sx + y * sy;
      for (int z = 0; z < kFieldEdge; ++z) *out++ = row[z * sz];
    }
  }
  return scratch;
}

WithLinks<SharedField> build_shared_field(const VoxelGrid& grid, const Pyramid& pyramid,
                                          const FieldOptions& options, const DenseArray* array) {
  detail::check_support(grid, pyramid, options.look_up);
  WithLinks<SharedField> r;
  const detail::BlockFinder blocks(grid);
  const auto link = [&](auto&& keeper) {
    detail::link_bricks(blocks, !grid.tiles.empty(), pyramid, options, keeper, r);
  };
  if (array == nullptr) {
    r.field.owner = grid.owner;
    r.field.shared_bytes = grid.bricks.size() * kBrickSamples * sizeof(float);
    link(InLeaves(grid, blocks, r.field));
  } else {
    const Vec3l size(array->size);
    r.field.shared_bytes = std::uint64_t(size.x * size.y * size.z) * sizeof(float);
    link(InArray(*array, blocks, r.field));
  }
  return r;
}

}  // namespace pvol
