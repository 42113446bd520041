#include "pvol/bounds/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "density/lattice_index.h"
#include "density/sample_range.h"
#include "pvol/bounds/node_index.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

using detail::BlockFinder;
using detail::BlockSource;
using detail::box_of;
using detail::PointBox;

/// A range that grows with what is added.
struct Range {
  float lo = std::numeric_limits<float>::infinity(), hi = -lo;

  void add(float v) { lo = std::min(lo, v), hi = std::max(hi, v); }
};

/// Adds the samples at the lattice points lo <= p <= hi of one aligned block.
void add_block(const BlockSource& b, Vec3i lo, Vec3i hi, Range& range) {
  if (b.values == nullptr) {
    range.add(b.constant);
    return;
  }
  const Vec3i first(lo.x & 7, lo.y & 7, lo.z & 7), last = first + (hi - lo);
  for (int i = first.x; i <= last.x; ++i) {
    for (int j = first.y; j <= last.y; ++j) {
      for (int k = first.z; k <= last.z; ++k) range.add(b.values[(i * 8 + j) * 8 + k]);
    }
  }
}

/// Adds the samples at lattice points lo <= p <= hi, where lo is a multiple of 8. Inside one tile
/// they are equal; elsewhere the box is halved until it lies in one block, so that huge uniform
/// cubes over huge tiles take no time.
void add_box(const BlockFinder& blocks, Vec3i lo, Vec3i hi, Range& range) {
  const BlockSource b = blocks.find(lo);
  const std::int32_t edge = b.values == nullptr && b.edge > 0 ? b.edge : kBrickEdge;
  const Vec3i room = Vec3i(lo.x & -edge, lo.y & -edge, lo.z & -edge) + Vec3i(edge - 1);
  int axis = -1;  // along which the box leaves the block or tile by most
  for (int a = 0; a < 3; ++a) {
    if (hi[a] > room[a] && (axis < 0 || hi[a] - lo[a] > hi[axis] - lo[axis])) axis = a;
  }
  if (axis < 0) {
    add_block(b, lo, hi, range);
    return;
  }
  const int middle = std::max(lo[axis] + kBrickEdge, (lo[axis] + (hi[axis] - lo[axis]) / 2) & -8);
  Vec3i low_end = hi, high_begin = lo;
  low_end[axis] = middle - 1, high_begin[axis] = middle;
  add_box(blocks, lo, low_end, range);
  add_box(blocks, high_begin, hi, range);
}

/// The same for boxes that begin anywhere.
void add_layers(const BlockFinder& blocks, Vec3i lo, Vec3i hi, Range& range) {
  const Vec3i first(lo.x & -8, lo.y & -8, lo.z & -8);
  if (first == lo) {
    add_box(blocks, lo, hi, range);
    return;
  }
  for (Vec3i b = first; b.x <= hi.x; b.x += kBrickEdge) {
    for (b.y = first.y; b.y <= hi.y; b.y += kBrickEdge) {
      for (b.z = first.z; b.z <= hi.z; b.z += kBrickEdge) {
        add_block(blocks.find(b), max(lo, b), min(hi, b + Vec3i(kBrickEdge - 1)), range);
      }
    }
  }
}

/// The cubes of a pyramid in index space.
struct Cubes {
  const Pyramid& pyramid;

  [[nodiscard]] std::int64_t edge(std::size_t level) const {
    return std::int64_t(kLeafEdge) << level;
  }
  [[nodiscard]] Vec3l origin(std::size_t level, std::uint64_t code) const {
    return pyramid.origin + Vec3l(morton_decode(code)) * edge(level);
  }
  [[nodiscard]] WrongBound describe(WrongBound::Kind kind, std::size_t level,
                                    std::uint64_t code) const {
    WrongBound w;
    w.kind = kind;
    w.depth = int(pyramid.levels.size() - 1 - level);
    w.lo_cell = origin(level, code);
    w.hi_cell = w.lo_cell + Vec3l(edge(level));
    return w;
  }
};

/// Blocks of 8^3 samples that may hold something: a cube of more blocks is not full.
double filled_blocks(const VoxelGrid& grid) {
  double count = double(grid.bricks.size());
  for (const Tile& t : grid.tiles) count += std::pow(double(t.edge) / kBrickEdge, 3);
  return count;
}

/// The samples that interpolation in a cube of cells reads. Of one that cannot be full, which a
/// damaged file may make as large as it likes, only those around the first block and the emptiness.
Range range_of(const BlockFinder& blocks, double filled, Vec3i lo, std::int64_t edge,
               KernelExtent extent) {
  Range range;
  if (std::pow(double(edge) / kBrickEdge, 3) > filled) {
    range.add(0);
    edge = kBrickEdge;
  }
  const Vec3i hi = lo + Vec3i(int(edge) - 1 + extent.above);
  if (extent.below == 0) {
    add_box(blocks, lo, hi, range);
    return range;
  }
  // Boxes begin at a block: the layers below the cube are boxes of their own.
  for (int corner = 0; corner < 8; ++corner) {
    Vec3i from = lo, to = hi;
    for (int a = 0; a < 3; ++a) {
      if (corner >> a & 1) from[a] = lo[a] - extent.below, to[a] = lo[a] - 1;
    }
    add_layers(blocks, from, to, range);
  }
  return range;
}

/// What is asked of cubes: bounds of their samples, or no more than one value of those that are
/// uniform.
enum class Ask { bounds, one_value };

/// Leaves and uniform cubes against their samples.
void check_cubes(const Cubes& cubes, const BlockFinder& blocks, double filled, std::size_t level,
                 Ask ask, BoundsCheck& check) {
  const auto& nodes = cubes.pyramid.levels[level];
  const KernelExtent extent = extent_of(cubes.pyramid.look_up);
  std::vector<std::size_t> own;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (level == 0 || is_uniform(cubes.pyramid, level, i)) own.push_back(i);
  }
  (level == 0 ? check.leaves : check.uniform) += own.size();
  std::vector<Range> found(own.size());
  parallel_parts(0, own.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k != end; ++k) {
      const Vec3i lo(cubes.origin(level, nodes[own[k]].code));
      found[k] = range_of(blocks, level == 0 ? filled + 1 : filled, lo, cubes.edge(level), extent);
    }
  });
  for (std::size_t k = 0; k < own.size(); ++k) {
    const PyramidNode& n = nodes[own[k]];
    const bool one_value = level == 0 || found[k].lo == found[k].hi;
    const bool bounded = n.lo <= found[k].lo && found[k].hi <= n.hi;
    if (one_value && (bounded || ask == Ask::one_value)) continue;
    WrongBound w = cubes.describe(level == 0 ? WrongBound::Kind::leaf : WrongBound::Kind::uniform,
                                  level, n.code);
    w.stored_lo = n.lo, w.stored_hi = n.hi;
    w.found_lo = found[k].lo, w.found_hi = found[k].hi;
    check.wrong.push_back(w);
  }
}

/// Finds places that the pyramid holds to be empty in boxes of cells that are not.
class MissingCubes {
 public:
  MissingCubes(const Cubes& cubes, const NodeIndex& leaves, const BlockFinder& blocks)
      : cubes_(cubes), leaves_(leaves), blocks_(blocks) {}

  /// Cells lo <= c <= hi.
  void look(Vec3l lo, Vec3l hi) {
    if (cubes_.pyramid.empty() || are_in_leaf(lo, hi)) return;
    descend(top(), 0, true, lo, hi);
  }

  void add(const MissingCubes& other) {
    places_.insert(places_.end(), other.places_.begin(), other.places_.end());
  }

  /// Each place once.
  void put(std::vector<WrongBound>& wrong) {
    std::sort(places_.begin(), places_.end());
    places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
    for (const auto& [level, code] : places_) {
      WrongBound w = cubes_.describe(WrongBound::Kind::missing, level, code);
      Range found;
      add_box(blocks_, Vec3i(w.lo_cell), Vec3i(w.hi_cell), found);
      w.found_lo = found.lo, w.found_hi = found.hi;
      wrong.push_back(w);
    }
  }

 private:
  [[nodiscard]] std::size_t top() const { return cubes_.pyramid.levels.size() - 1; }

  /// Whether all are in one leaf that is there, as most are: known without a descent.
  [[nodiscard]] bool are_in_leaf(Vec3l lo, Vec3l hi) const {
    Vec3<std::uint32_t> leaf;
    for (int a = 0; a < 3; ++a) {
      const std::int64_t from = lo[a] - cubes_.pyramid.origin[a], to = from + hi[a] - lo[a];
      if (from < 0 || from >= cubes_.edge(top()) || from / kLeafEdge != to / kLeafEdge)
        return false;
      leaf[a] = std::uint32_t(from / kLeafEdge);
    }
    return leaves_.find(morton_encode(leaf)).has_value();
  }

  /// Below a cube that is not there, on to the leaves or what the box fills.
  void descend(std::size_t level, std::uint64_t code, bool there, Vec3l lo, Vec3l hi) {
    const Vec3l first = cubes_.origin(level, code), last = first + Vec3l(cubes_.edge(level) - 1);
    for (int a = 0; a < 3; ++a) {
      if (hi[a] < first[a] || lo[a] > last[a]) return;
    }
    const auto node = there ? find(cubes_.pyramid.levels[level], code) : std::nullopt;
    if (node && (level == 0 || is_uniform(cubes_.pyramid, level, *node))) return;
    const bool filled = min(lo, first) == lo && max(hi, last) == hi;
    if (!node && (level == 0 || filled)) {
      places_.emplace_back(level, code);
      return;
    }
    for (std::uint64_t child = 0; child < 8; ++child) {
      descend(level - 1, 8 * code + child, node.has_value(), lo, hi);
    }
  }

  const Cubes& cubes_;
  const NodeIndex& leaves_;
  const BlockFinder& blocks_;
  std::vector<std::pair<std::size_t, std::uint64_t>> places_;
};

/// What the samples of a brick need: cubes around all cells in which they have density. These lie
/// in its own leaf and, where samples reach across its faces, in the leaves around it, for each of
/// which one cell is enough: the leaf is there, or it is not.
void look_around(const Brick& brick, const PointBox& box, KernelExtent extent,
                 MissingCubes& missing) {
  const Vec3l origin(brick.origin), last(kBrickEdge - 1);
  missing.look(max(box.lo - Vec3l(extent.above), origin),
               min(box.hi + Vec3l(extent.below), origin + last));
  const Vec3l lo = box.lo - origin, hi = box.hi - origin;
  for (int neighbour = 0; neighbour < 27; ++neighbour) {
    const Vec3l step(neighbour / 9 - 1, neighbour / 3 % 3 - 1, neighbour % 3 - 1);
    const auto reaches = [&](Vec3l from, Vec3l to) {  // some of the samples from .. to
      for (int a = 0; a < 3; ++a) {
        if (step[a] < 0 && from[a] >= extent.above) return false;
        if (step[a] > 0 && to[a] < kBrickEdge - extent.below) return false;
      }
      return true;
    };
    if (step == Vec3l(0) || !reaches(lo, hi)) continue;
    for (int i = 0; i < kBrickSamples; ++i) {
      const Vec3l at(i >> 6, i >> 3 & 7, i & 7);
      if (!(brick.values[i] > 0) || !reaches(at, at)) continue;
      Vec3l cell = at;
      for (int a = 0; a < 3; ++a) {
        if (step[a] != 0) cell[a] = step[a] < 0 ? -1 : kBrickEdge;
      }
      missing.look(origin + cell, origin + cell);
      break;
    }
  }
}

/// Every sample above 0 against the cubes and the box around the cells in which it has density.
void check_places(const VoxelGrid& grid, const Cubes& cubes, const BlockFinder& blocks,
                  BoundsCheck& check) {
  const KernelExtent extent = extent_of(cubes.pyramid.look_up);
  const Vec3l above(extent.above), below(extent.below);
  const NodeIndex leaves(cubes.pyramid);
  MissingCubes missing(cubes, leaves, blocks);
  PointBox all;
  std::mutex mutex;
  parallel_parts(0, grid.bricks.size(), 64, [&](std::size_t begin, std::size_t end) {
    MissingCubes part(cubes, leaves, blocks);
    PointBox of_part;
    for (std::size_t k = begin; k != end; ++k) {
      const PointBox box = box_of(grid.bricks[k]);
      if (box.empty()) continue;
      of_part.add(box.lo, box.hi);
      look_around(grid.bricks[k], box, extent, part);
    }
    const std::scoped_lock lock(mutex);
    missing.add(part);
    if (!of_part.empty()) all.add(of_part.lo, of_part.hi);
  });
  for (const Tile& t : grid.tiles) {
    if (!(t.value > 0)) continue;
    const Vec3l lo(t.origin), hi = lo + Vec3l(t.edge - 1);
    all.add(lo, hi);
    missing.look(lo - above, hi + below);
  }
  missing.put(check.wrong);
  if (all.empty()) return;
  const WrongSupport s{cubes.pyramid.support_lo, cubes.pyramid.support_hi, all.lo - above,
                       all.hi + below + Vec3l(1)};
  if (min(s.stored_lo, s.found_lo) != s.stored_lo || max(s.stored_hi, s.found_hi) != s.stored_hi) {
    check.support = s;
  }
}

/// Cubes from this level up, and places.
BoundsCheck verify(const VoxelGrid& grid, const Pyramid& pyramid, std::size_t first_level,
                   Ask ask) {
  BoundsCheck check;
  const BlockFinder blocks(grid);
  const Cubes cubes{pyramid};
  const double filled = filled_blocks(grid);
  for (std::size_t level = first_level; level < pyramid.levels.size(); ++level) {
    check_cubes(cubes, blocks, filled, level, ask, check);
  }
  check_places(grid, cubes, blocks, check);
  return check;
}

}  // namespace

double WrongBound::off() const {
  double worst = 0;
  if (found_hi > stored_hi) worst = (double(found_hi) - double(stored_hi)) / double(found_hi);
  if (stored_lo > found_lo) {
    worst = std::max(worst, (double(stored_lo) - double(found_lo)) / double(stored_lo));
  }
  return worst;
}

BoundsCheck verify_bounds(const VoxelGrid& grid, const Pyramid& pyramid) {
  BoundsCheck check = verify(grid, pyramid, 0, Ask::bounds);
  std::stable_sort(check.wrong.begin(), check.wrong.end(),
                   [](const WrongBound& a, const WrongBound& b) { return a.off() > b.off(); });
  return check;
}

BoundsCheck verify_cover(const VoxelGrid& grid, const Pyramid& pyramid) {
  return verify(grid, pyramid, 1, Ask::one_value);
}

}  // namespace pvol
