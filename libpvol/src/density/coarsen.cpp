#include "pvol/density/coarsen.h"

#include <algorithm>
#include <array>
#include <memory>

#include "density/lattice_index.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

/// Fine samples along an axis that eight coarse ones read: 2 I - 1 .. 2 I + 1.
constexpr int kReach = 2 * kBrickEdge + 1;

/// The block that holds a lattice point, by its origin.
Vec3i block_of(Vec3i p) { return {p.x & -kBrickEdge, p.y & -kBrickEdge, p.z & -kBrickEdge}; }

/// Half of a lattice point, rounded down.
Vec3i half(Vec3i p) { return {p.x >> 1, p.y >> 1, p.z >> 1}; }

/// Origins of the coarse blocks that fine samples lo..hi (inclusive) reach, without repetition.
class Blocks {
 public:
  void add(Vec3i lo, Vec3i hi) {
    const Vec3i first = block_of(half(lo)), last = block_of(half(hi + Vec3i(1)));
    for (std::int32_t x = first.x; x <= last.x; x += kBrickEdge) {
      for (std::int32_t y = first.y; y <= last.y; y += kBrickEdge) {
        for (std::int32_t z = first.z; z <= last.z; z += kBrickEdge) found_.push_back({x, y, z});
      }
    }
    constexpr std::size_t kMost = std::size_t(1) << 21;  // 4 GB
    if (found_.size() > kMost) {
      throw Error(
          "the cloud is too large for a preview, which would need more than 2^21 bricks; render it "
          "without --preview");
    }
  }

  [[nodiscard]] std::vector<Vec3i> take() {
    const auto before = [](Vec3i a, Vec3i b) {
      return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
    };
    std::sort(found_.begin(), found_.end(), before);
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    return std::move(found_);
  }

 private:
  std::vector<Vec3i> found_;
};

/// The fine samples around a coarse block, [x][y][z].
using Neighbourhood = std::array<std::array<std::array<float, kReach>, kReach>, kReach>;

void gather(const detail::BlockFinder& blocks, Vec3i coarse, Neighbourhood& out) {
  const Vec3i first = coarse * 2 - Vec3i(1);
  const Vec3i from = block_of(first), to = first + Vec3i(kReach);
  for (std::int32_t x = from.x; x < to.x; x += kBrickEdge) {
    for (std::int32_t y = from.y; y < to.y; y += kBrickEdge) {
      for (std::int32_t z = from.z; z < to.z; z += kBrickEdge) {
        const Vec3i at(x, y, z);
        const detail::BlockSource b = blocks.find(at);
        const Vec3i lo = max(at, first), hi = min(at + Vec3i(kBrickEdge), to);
        for (std::int32_t i = lo.x; i < hi.x; ++i) {
          for (std::int32_t j = lo.y; j < hi.y; ++j) {
            for (std::int32_t k = lo.z; k < hi.z; ++k) {
              const Vec3i p = Vec3i(i, j, k) - at, q = Vec3i(i, j, k) - first;
              out[std::size_t(q.x)][std::size_t(q.y)][std::size_t(q.z)] =
                  b.values ? b.values[(p.x * kBrickEdge + p.y) * kBrickEdge + p.z] : b.constant;
            }
          }
        }
      }
    }
  }
}

float weighted_mean(const Neighbourhood& n, int x, int y, int z) {
  constexpr double kWeight[3] = {0.25, 0.5, 0.25};
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const auto& row = n[std::size_t(2 * x + i)][std::size_t(2 * y + j)];
      double line = 0;
      for (int k = 0; k < 3; ++k) line += kWeight[k] * double(row[std::size_t(2 * z + k)]);
      sum += kWeight[i] * kWeight[j] * line;
    }
  }
  return float(sum);
}

void fill(const detail::BlockFinder& blocks, Vec3i coarse, float* values) {
  Neighbourhood n;
  gather(blocks, coarse, n);
  for (int x = 0; x < kBrickEdge; ++x) {
    for (int y = 0; y < kBrickEdge; ++y) {
      for (int z = 0; z < kBrickEdge; ++z) *values++ = weighted_mean(n, x, y, z);
    }
  }
}

}  // namespace

VoxelGrid coarsen(const VoxelGrid& grid) {
  Blocks reached;
  for (const Brick& b : grid.bricks) reached.add(b.origin, b.origin + Vec3i(kBrickEdge - 1));
  for (const Tile& t : grid.tiles) reached.add(t.origin, t.origin + Vec3i(t.edge - 1));
  const std::vector<Vec3i> origins = reached.take();
  const auto values = std::make_shared<std::vector<float>>(origins.size() * kBrickSamples);
  const detail::BlockFinder blocks(grid);
  parallel_for(0, origins.size(), [&](std::size_t i) {
    fill(blocks, origins[i], values->data() + i * kBrickSamples);
  });

  VoxelGrid coarse;
  coarse.name = grid.name;
  coarse.index_to_world = grid.index_to_world * scaling(Vec3d(2));
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const float* v = values->data() + i * kBrickSamples;
    if (std::any_of(v, v + kBrickSamples, [](float d) { return d > 0; })) {
      coarse.bricks.push_back({origins[i], v});
    }
  }
  coarse.owner = values;
  return coarse;
}

}  // namespace pvol
