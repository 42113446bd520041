#include "pvol/field/vector_bricks.h"

#include <array>
#include <map>
#include <optional>

#include "density/lattice_index.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

using detail::BlockFinder;
using detail::BlockSource;

/// Fills the bricks of one field of vectors.
class Builder {
 public:
  Builder(Components grids, const std::function<Float4(Float4)>& value, Vec3i first_leaf)
      : value_(value), first_(first_leaf) {
    blocks_.reserve(grids.size());
    for (const VoxelGrid* grid : grids) blocks_.emplace_back(*grid);
  }

  void fill(VectorBricks& d) {
    d.samples.assign(VectorBricks::kSamples, Float4{});
    std::map<std::array<float, 4>, std::uint32_t> constant{{{0, 0, 0, 0}, 0}};
    std::vector<std::size_t> own;
    std::size_t bricks = 1;
    d.brick_of.resize(std::size_t(d.leaves.x) * std::size_t(d.leaves.y) * std::size_t(d.leaves.z));
    for (std::size_t i = 0; i < d.brick_of.size(); ++i) {
      const auto same = constant_in(origin_of(d, i));
      if (!same) {
        own.push_back(i);
        continue;
      }
      const auto [at, fresh] = constant.try_emplace(*same, std::uint32_t(bricks));
      if (fresh) {
        const auto& [x, y, z, w] = *same;
        d.samples.insert(d.samples.end(), std::size_t(VectorBricks::kSamples),
                         value_(Float4{x, y, z, w}));
        ++bricks;
      }
      d.brick_of[i] = at->second;
    }
    d.samples.resize((bricks + own.size()) * VectorBricks::kSamples);
    parallel_parts(0, own.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k != end; ++k) {
        d.brick_of[own[k]] = std::uint32_t(bricks + k);
        gather(origin_of(d, own[k]), d.samples.data() + (bricks + k) * VectorBricks::kSamples);
      }
    });
  }

 private:
  std::vector<BlockFinder> blocks_;
  const std::function<Float4(Float4)>& value_;
  Vec3i first_;

  [[nodiscard]] Vec3i origin_of(const VectorBricks& d, std::size_t i) const {
    const auto y = std::size_t(d.leaves.y), z = std::size_t(d.leaves.z);
    return (first_ + Vec3i(int(i / z / y), int(i / z % y), int(i % z))) * kBrickEdge;
  }

  /// The one vector of a leaf where tiles or empty space show it without a look at samples.
  [[nodiscard]] std::optional<std::array<float, 4>> constant_in(Vec3i leaf) const {
    std::array<float, 4> value{};
    for (std::size_t c = 0; c < blocks_.size(); ++c) {
      value[c] = blocks_[c].find(leaf).constant;
      bool same = true;
      detail::for_blocks_in_extent(blocks_[c], leaf, {0, 1},
                                   [&](const BlockSource& b, Vec3i, Vec3i, Vec3i) {
                                     same &= b.values == nullptr && b.constant == value[c];
                                   });
      if (!same) return std::nullopt;
    }
    return value;
  }

  void gather(Vec3i leaf, Float4* out) const {
    constexpr int kEdge = VectorBricks::kEdge;
    std::array<std::array<float, 4>, VectorBricks::kSamples> samples{};
    for (std::size_t c = 0; c < blocks_.size(); ++c) {
      const auto copy = [&](const BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
        for (int i = 0; i < count.x; ++i) {
          for (int j = 0; j < count.y; ++j) {
            for (int k = 0; k < count.z; ++k) {
              const int at = ((from.x + i) * 8 + from.y + j) * 8 + from.z + k;
              const int sample = ((to.x + i) * kEdge + to.y + j) * kEdge + to.z + k;
              samples[std::size_t(sample)][c] = b.values ? b.values[at] : b.constant;
            }
          }
        }
      };
      detail::for_blocks_in_extent(blocks_[c], leaf, {0, 1}, copy);
    }
    for (std::size_t i = 0; i < samples.size(); ++i) out[i] = value_(load(samples[i].data()));
  }
};

}  // namespace

void LeafBox::add(Vec3i origin, int edge) {
  // Cells below the first sample have it for a corner.
  lo = min(lo, Vec3i(origin.x >> 3, origin.y >> 3, origin.z >> 3) - Vec3i(1));
  hi = max(hi, Vec3i((origin.x + edge) >> 3, (origin.y + edge) >> 3, (origin.z + edge) >> 3));
}

double LeafBox::count() const {
  const Vec3d size(hi - lo + Vec3i(1));
  return size.x * size.y * size.z;
}

LeafBox leaf_box(Components grids) {
  LeafBox box;
  for (const VoxelGrid* grid : grids) {
    for (const Brick& b : grid->bricks) box.add(b.origin, kBrickEdge);
    for (const Tile& t : grid->tiles) box.add(t.origin, t.edge);
  }
  return box;
}

VectorBricks make_vector_bricks(Components grids, const LeafBox& box,
                                const std::function<Float4(Float4)>& value) {
  VectorBricks d;
  d.leaves = box.hi - box.lo + Vec3i(1);
  Builder(grids, value, box.lo).fill(d);
  return d;
}

}  // namespace pvol
