// Bounds of every leaf from all samples in its reach, then level by level to the root.
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <mutex>

#include "bounds/pyramid_parts.h"
#include "density/lattice_index.h"
#include "density/sample_range.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

struct Extent {
  detail::PointBox points;
  float largest = 0;
};

/// Non-zero samples: where they are, and the largest.
Extent measure(const VoxelGrid& grid) {
  const auto join = [](Extent a, const Extent& b) {
    a.points.add(b.points);
    a.largest = std::max(a.largest, b.largest);
    return a;
  };
  Extent e;
  std::mutex mutex;
  parallel_parts(0, grid.bricks.size(), 64, [&](std::size_t begin, std::size_t end) {
    Extent part;
    for (std::size_t i = begin; i != end; ++i) {
      const Brick& b = grid.bricks[i];
      const Vec3l origin(b.origin);
      if (!part.points.contains({origin, origin + Vec3l(kBrickEdge - 1)})) {
        part.points.add(detail::box_of(b));
      }
      detail::SampleRange range;
      range.add(b.values, kBrickSamples);
      part.largest = std::max(part.largest, range.hi());
    }
    const std::lock_guard lock(mutex);
    e = join(e, part);
  });
  for (const Tile& t : grid.tiles) {
    if (t.value == 0) continue;
    const Vec3l lo(t.origin);
    e = join(e, {{lo, lo + Vec3l(t.edge - 1)}, t.value});
  }
  return e;
}

using LeafCoord = Vec3<std::int64_t>;  // in leaves, from the pyramid's origin

/// What to evaluate: leaves at bricks and at the borders of tiles, and uniform cubes inside tiles.
struct Candidates {
  std::vector<std::uint64_t> leaves;              // Morton codes, ascending
  std::vector<std::vector<PyramidNode>> uniform;  // by level, with the exact value as lo and hi
};

class Collector {
 public:
  Collector(const Pyramid& pyramid, std::uint64_t max_leaves)
      : origin_(pyramid.origin),
        root_level_(int(pyramid.levels.size()) - 1),
        below_(extent_of(pyramid.look_up).below),
        left_(max_leaves) {
    found_.uniform.resize(pyramid.levels.size());
  }

  void add(const Brick& brick) { add_border(leaf_of(brick.origin), 1); }

  void add(const Tile& tile) {
    if (tile.value == 0) return;
    const std::int64_t n = tile.edge / kLeafEdge;
    add_border(leaf_of(tile.origin), n);
    const std::int64_t inner = n - 1 - below_;
    if (inner > 0) {
      add_uniform({leaf_of(tile.origin) + LeafCoord(below_), inner, tile.value}, root_level_, {});
    }
  }

  Candidates take() {
    auto& leaves = found_.leaves;
    tbb::parallel_sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    return std::move(found_);
  }

 private:
  Vec3l origin_;
  int root_level_;
  std::int64_t below_;  // 1 where leaves read the block before their own, else 0
  std::uint64_t left_;  // how many more leaves and cubes may be collected
  Candidates found_;

  [[nodiscard]] LeafCoord leaf_of(Vec3i at) const {
    const Vec3l d = Vec3l(at) - origin_;
    return {d.x / kLeafEdge, d.y / kLeafEdge, d.z / kLeafEdge};
  }

  void take_from_budget(std::uint64_t count) {
    if (count > left_) {
      throw Error(
          "the density has too many leaves of 8^3 voxels to bound, because it holds huge constant "
          "tiles. Crop the volume or resample it to larger voxels.");
    }
    left_ -= count;
  }

  /// The leaves that read a block of n^3 leaf-sized sample blocks from c up and others besides:
  /// those at its upper faces, and those one lower, whose last samples are the block's first; where
  /// kernels reach below their cell, also those at its lower faces and those one higher.
  void add_border(LeafCoord c, std::int64_t n) {
    const auto cube = [](std::int64_t e) { return std::uint64_t(e * e * e); };
    const std::int64_t inner = std::max<std::int64_t>(0, n - 1 - below_);
    if (n > 1) take_from_budget(cube(n + 1 + below_) - cube(inner));  // bricks are there already
    const auto is_inner = [&](std::int64_t v) { return v >= below_ && v < n - 1; };
    for (std::int64_t x = -1; x < n + below_; ++x) {
      for (std::int64_t y = -1; y < n + below_; ++y) {
        for (std::int64_t z = -1; z < n + below_; ++z) {
          if (is_inner(x) && is_inner(y) && is_inner(z)) z = n - 1;
          add_leaf(c + LeafCoord(x, y, z));
        }
      }
    }
  }

  /// Leaves outside the root read nothing but zeros.
  void add_leaf(LeafCoord c) {
    const std::int64_t edge = std::int64_t(1) << root_level_;
    if (min_component(c) < 0 || max_component(c) >= edge) return;
    found_.leaves.push_back(morton_encode(Vec3<std::uint32_t>(c)));
  }

  struct Uniform {
    LeafCoord lo;
    std::int64_t edge;
    float value;
  };

  /// Splits a cube of equal leaves into the fewest octree cubes, from the one of `level` at `at`.
  void add_uniform(const Uniform& u, int level, LeafCoord at) {
    const std::int64_t edge = std::int64_t(1) << level;
    const LeafCoord lo = max(at, u.lo), hi = min(at + LeafCoord(edge), u.lo + LeafCoord(u.edge));
    const LeafCoord common = hi - lo;
    if (min_component(common) <= 0) return;
    if (min_component(common) == edge) {
      take_from_budget(1);
      const Vec3<std::uint32_t> cube(LeafCoord(at.x >> level, at.y >> level, at.z >> level));
      found_.uniform[std::size_t(level)].push_back({morton_encode(cube), u.value, u.value});
      return;
    }
    for (int child = 0; child < 8; ++child) {
      const LeafCoord half(child & 1, child >> 1 & 1, child >> 2);
      add_uniform(u, level - 1, at + half * (edge / 2));
    }
  }
};

/// Extremes of the samples that the interpolants of a leaf's cells read (THEORY.md, T1.1, T1.4).
detail::SampleRange leaf_range(const detail::BlockFinder& blocks, Vec3i origin,
                               KernelExtent extent) {
  detail::SampleRange r;
  const auto add = [&](const detail::BlockSource& b, Vec3i from, Vec3i count, Vec3i) {
    if (b.values == nullptr) {
      r.add(&b.constant, 1);
    } else if (count == Vec3i(kBrickEdge)) {
      r.add(b.values, kBrickSamples);
    } else {
      for (int i = from.x; i < from.x + count.x; ++i) {
        for (int j = from.y; j < from.y + count.y; ++j) {
          r.add(b.values + (i * 8 + j) * 8 + from.z, count.z);
        }
      }
    }
  };
  detail::for_blocks_in_extent(blocks, origin, extent, add);
  return r;
}

}  // namespace

Pyramid build_pyramid(const VoxelGrid& grid, LookUp look_up, std::uint64_t max_leaves) {
  if (look_up == LookUp::procedural) {
    throw Error(
        "found samples with procedural look-ups; expected a recipe: bound the recipe itself");
  }
  const Extent extent = measure(grid);
  Pyramid p;
  if (look_up == LookUp::tricubic) p.look_up = look_up;
  if (extent.points.empty()) return p;
  detail::place_root(p, extent.points.lo, extent.points.hi, extent.largest);

  const detail::BlockFinder blocks(grid);
  Collector collector(p, max_leaves);
  for (const Brick& b : grid.bricks) collector.add(b);
  for (const Tile& t : grid.tiles) collector.add(t);
  Candidates candidates = collector.take();
  std::vector<PyramidNode> leaves(candidates.leaves.size());
  parallel_parts(0, leaves.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      const std::uint64_t code = candidates.leaves[i];
      const Vec3l at = p.origin + Vec3l(morton_decode(code)) * kLeafEdge;
      const detail::SampleRange range = leaf_range(blocks, Vec3i(at), extent_of(p.look_up));
      leaves[i] = detail::quantize({code, range.lo(), range.hi()}, p.scale);
    }
  });
  std::erase_if(leaves, [](const PyramidNode& n) { return n.hi == 0; });

  p.levels = std::move(candidates.uniform);
  for (std::vector<PyramidNode>& level : p.levels) {
    for (PyramidNode& n : level) n = detail::quantize(n, p.scale);
  }
  p.levels[0].insert(p.levels[0].end(), leaves.begin(), leaves.end());
  for (std::vector<PyramidNode>& level : p.levels) {
    std::sort(level.begin(), level.end(),
              [](const auto& a, const auto& b) { return a.code < b.code; });
  }
  complete_levels(p);
  return p;
}

}  // namespace pvol
