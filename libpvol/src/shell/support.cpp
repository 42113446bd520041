#include "pvol/shell/support.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <string>

#include "density/lattice_index.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

constexpr CellMask kAllCells = {~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};
constexpr CellMask kNoCells{};

/// Which of the samples that a leaf's cells read are above 0: bit z of row[x][y]; 9^3 of them, or
/// 11^3 for tricubic interpolation.
struct SampleBits {
  KernelExtent reach;
  std::uint16_t row[11][11] = {};
};

SampleBits samples_above_zero(const detail::BlockFinder& blocks, Vec3i origin, KernelExtent reach) {
  SampleBits bits{reach};
  const auto add = [&](const detail::BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
    if (b.values == nullptr && b.constant == 0) return;
    const Vec3i first = to + Vec3i(reach.below);
    for (int x = 0; x < count.x; ++x) {
      for (int y = 0; y < count.y; ++y) {
        const int start = ((from.x + x) * 8 + from.y + y) * 8 + from.z;
        unsigned row = 0;
        for (int z = 0; z < count.z; ++z) {
          const bool above = b.values == nullptr || b.values[start + z] > 0;
          row |= unsigned(above) << z;
        }
        std::uint16_t& to_row = bits.row[first.x + x][first.y + y];
        to_row = std::uint16_t(to_row | row << first.z);
      }
    }
  };
  detail::for_blocks_in_extent(blocks, origin, reach, add);
  return bits;
}

/// A cell is occupied where a sample that it reads is above 0.
CellMask occupied_cells(const SampleBits& bits) {
  const int width = bits.reach.below + bits.reach.above + 1;
  CellMask mask{};
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      unsigned read = 0;
      for (int i = 0; i < width; ++i) {
        for (int j = 0; j < width; ++j) read |= bits.row[x + i][y + j];
      }
      unsigned cells = 0;
      for (int k = 0; k < width; ++k) cells |= read >> k;
      mask[std::size_t(x)] |= std::uint64_t(cells & 0xff) << (8 * y);
    }
  }
  return mask;
}

/// The bits of word x that belong to edge^2 cells from (y, z) up; edge 1, 2, 4 or 8.
std::uint64_t square_bits(int edge, int y, int z) {
  constexpr std::uint64_t kSquares[] = {0x1, 0x303, 0x0f0f0f0f, ~0ull};
  return kSquares[std::countr_zero(unsigned(edge))] << (8 * y + z);
}

int count_cells(const CellMask& mask) {
  int n = 0;
  for (const std::uint64_t word : mask) n += std::popcount(word);
  return n;
}

/// Occupied cells among edge^3 of the block from `lo` up.
int count_cells(const CellMask& mask, Vec3i lo, int edge) {
  int n = 0;
  for (int x = lo.x; x < lo.x + edge; ++x) {
    n += std::popcount(mask[std::size_t(x)] & square_bits(edge, lo.y, lo.z));
  }
  return n;
}

/// Morton codes of the blocks in a cube of level L are one range of this length.
std::uint64_t blocks_in(std::uint32_t level) { return 1ull << (3 * level); }

/// Whether the last eight cubes are the children of one cube of the next level.
bool are_siblings(const std::vector<SupportBlock>& cubes) {
  if (cubes.size() < 8) return false;
  const std::uint32_t level = cubes.back().level;
  const SupportBlock* const first = &cubes[cubes.size() - 8];
  if (first->code % blocks_in(level + 1) != 0) return false;
  for (std::uint64_t i = 0; i < 8; ++i) {
    if (first[i].level != level || first[i].code != first->code + i * blocks_in(level)) {
      return false;
    }
  }
  return true;
}

/// Joins eight full cubes that make up their parent, until there are none. `cubes` ascend.
std::vector<SupportBlock> merge(const std::vector<SupportBlock>& cubes) {
  std::vector<SupportBlock> merged;
  for (const SupportBlock& cube : cubes) {
    merged.push_back(cube);
    while (are_siblings(merged)) {
      merged.resize(merged.size() - 7);
      merged.back() = {merged.back().code, merged.back().level + 1, 0};
    }
  }
  return merged;
}

Vec3l corner_of(const Support& s, std::uint64_t code) {
  return s.origin + Vec3l(morton_decode(code)) * kLeafEdge;
}

/// The tight box, and the number of cells.
void measure(Support& s) {
  s.lo = Vec3l(std::numeric_limits<std::int64_t>::max());
  s.hi = Vec3l(std::numeric_limits<std::int64_t>::min());
  const auto add = [&](Vec3l lo, Vec3l hi) { s.lo = min(s.lo, lo), s.hi = max(s.hi, hi); };
  for (const SupportBlock& b : s.blocks) {
    const Vec3l at = corner_of(s, b.code);
    if (b.level > 0) {
      const std::int64_t edge = std::int64_t(kLeafEdge) << b.level;
      s.cells += std::uint64_t(edge) * std::uint64_t(edge) * std::uint64_t(edge);
      add(at, at + Vec3l(edge));
      continue;
    }
    const CellMask& mask = s.masks[b.mask];
    s.cells += std::uint64_t(count_cells(mask));
    if (min(s.lo, at) == s.lo && max(s.hi, at + Vec3l(kLeafEdge)) == s.hi) continue;
    for (int x = 0; x < 8; ++x) {
      for (std::uint64_t word = mask[std::size_t(x)]; word != 0; word &= word - 1) {
        const int bit = std::countr_zero(word);
        const Vec3l cell = at + Vec3l(x, bit / 8, bit % 8);
        add(cell, cell + Vec3l(1));
      }
    }
  }
  if (s.empty()) s.lo = s.hi = s.origin;
}

constexpr std::uint32_t kFullMask = 0xffffffffu;  // marks a full block of level 0 while merging

}  // namespace

Support make_support(Vec3l origin, int root_log2, std::vector<MaskedBlock> parts,
                     std::vector<SupportBlock> full) {
  Support s;
  s.origin = origin;
  s.root_log2 = root_log2;
  std::erase_if(parts, [](const MaskedBlock& b) { return b.mask == kNoCells; });
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool all = parts[i].mask == kAllCells;
    full.push_back({parts[i].code, 0, all ? kFullMask : std::uint32_t(i)});
  }
  std::sort(full.begin(), full.end(), [](const auto& a, const auto& b) { return a.code < b.code; });
  // Only full cubes merge: a block with a mask of its own stands between them as one that has none
  // of their sizes.
  std::vector<SupportBlock> run;
  const auto flush = [&] {
    for (const SupportBlock& b : merge(run)) s.blocks.push_back(b);
    run.clear();
  };
  for (const SupportBlock& b : full) {
    if (b.level > 0 || b.mask == kFullMask) {
      run.push_back(b);
    } else {
      flush();
      s.blocks.push_back(b);
    }
  }
  flush();
  for (SupportBlock& b : s.blocks) {
    if (b.level > 0) {
      b.mask = 0;
      continue;
    }
    const CellMask mask = b.mask == kFullMask ? kAllCells : parts[b.mask].mask;
    b.mask = std::uint32_t(s.masks.size());
    s.masks.push_back(mask);
  }
  measure(s);
  return s;
}

Support make_support(const VoxelGrid& grid, const Pyramid& pyramid) {
  if (pyramid.empty()) return {};
  const detail::BlockFinder blocks(grid);
  const KernelExtent reach = extent_of(pyramid.look_up);
  const std::vector<PyramidNode>& leaves = pyramid.levels[0];
  std::vector<MaskedBlock> parts(leaves.size());
  parallel_for(0, leaves.size(), [&](std::size_t i) {
    const Vec3l at = pyramid.origin + Vec3l(morton_decode(leaves[i].code)) * kLeafEdge;
    parts[i] = {leaves[i].code, occupied_cells(samples_above_zero(blocks, Vec3i(at), reach))};
  });
  std::vector<SupportBlock> full;
  for (std::size_t level = 1; level < pyramid.levels.size(); ++level) {
    for (std::size_t i = 0; i < pyramid.levels[level].size(); ++i) {
      if (!is_uniform(pyramid, level, i)) continue;
      const std::uint64_t code = pyramid.levels[level][i].code << (3 * level);
      full.push_back({code, std::uint32_t(level), 0});
    }
  }
  return make_support(pyramid.origin, pyramid.root_log2(), std::move(parts), std::move(full));
}

Support make_support(const std::vector<Vec3l>& cells) {
  if (cells.empty()) return {};
  Vec3l lo = cells.front(), hi = cells.front();
  for (const Vec3l& cell : cells) lo = min(lo, cell), hi = max(hi, cell);
  const Vec3l origin{lo.x & ~std::int64_t(7), lo.y & ~std::int64_t(7), lo.z & ~std::int64_t(7)};
  int root_log2 = 3;
  while (root_log2 <= kMaxRootLog2 && max_component(hi - origin) >> root_log2 != 0) ++root_log2;
  if (root_log2 > kMaxRootLog2) {
    throw Error(std::to_string(max_component(hi - lo) + 1) +
                " cells along an axis; a support holds at most 2^24");
  }
  struct Place {
    std::uint64_t code;
    Vec3i in_block;
  };
  std::vector<Place> places;
  places.reserve(cells.size());
  for (const Vec3l& cell : cells) {
    const Vec3<std::uint32_t> d(cell - origin);
    const Vec3<std::uint32_t> block{d.x / 8, d.y / 8, d.z / 8};
    places.push_back({morton_encode(block), Vec3i(d) - Vec3i(block) * 8});
  }
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b) { return a.code < b.code; });
  std::vector<MaskedBlock> parts;
  for (const Place& p : places) {
    if (parts.empty() || parts.back().code != p.code) parts.push_back({p.code, {}});
    parts.back().mask[std::size_t(p.in_block.x)] |= 1ull << (8 * p.in_block.y + p.in_block.z);
  }
  return make_support(origin, root_log2, std::move(parts));
}

bool is_occupied(const Support& support, Vec3l cell) {
  if (min(cell, support.lo) != support.lo ||
      max(cell, support.hi - Vec3l(1)) != support.hi - Vec3l(1)) {
    return false;
  }
  const Vec3<std::uint32_t> d(cell - support.origin);
  const std::uint64_t code = morton_encode({d.x / 8, d.y / 8, d.z / 8});
  const auto after =
      std::upper_bound(support.blocks.begin(), support.blocks.end(), code,
                       [](std::uint64_t c, const SupportBlock& b) { return c < b.code; });
  if (after == support.blocks.begin()) return false;
  const SupportBlock& b = *(after - 1);
  if (b.level > 0) return code - b.code < blocks_in(b.level);
  return code == b.code && (support.masks[b.mask][d.x % 8] >> (8 * (d.y % 8) + d.z % 8) & 1);
}

namespace {

/// A node above or at the level of blocks, given its blocks.
SupportNode make_node(const Support& s, Vec3l lo, int log2, std::size_t begin, std::size_t end) {
  SupportNode node{lo, log2, begin, end, false};
  if (end - begin == 1) {
    const SupportBlock& b = s.blocks[begin];
    node.full = int(b.level) + 3 == log2 && (b.level > 0 || s.masks[b.mask] == kAllCells);
  }
  return node;
}

std::uint64_t code_of(const Support& s, Vec3l lo) {
  const Vec3<std::uint32_t> d(lo - s.origin);
  return morton_encode({d.x / 8, d.y / 8, d.z / 8});
}

}  // namespace

SupportNode root(const Support& support) {
  return make_node(support, support.origin, support.root_log2, 0, support.blocks.size());
}

SupportChildren children(const Support& support, const SupportNode& node) {
  SupportChildren result;
  const int log2 = node.log2 - 1;
  const std::int64_t edge = std::int64_t(1) << log2;
  const auto add = [&](const SupportNode& child) {
    result.node[std::size_t(result.count++)] = child;
  };
  std::size_t begin = node.begin;
  for (int c = 0; c < 8; ++c) {
    const Vec3l lo = node.lo + Vec3l(c & 1, c >> 1 & 1, c >> 2) * edge;
    if (node.full) {
      add({lo, log2, node.begin, node.end, true});
    } else if (log2 >= 3) {
      const std::uint64_t last = code_of(support, lo) + blocks_in(std::uint32_t(log2 - 3));
      const auto first = support.blocks.begin();
      const auto at =
          std::lower_bound(first + std::ptrdiff_t(begin), first + std::ptrdiff_t(node.end), last,
                           [](const SupportBlock& b, std::uint64_t code) { return b.code < code; });
      const auto end = std::size_t(at - first);
      if (end > begin) add(make_node(support, lo, log2, begin, end));
      begin = end;
    } else {
      const SupportBlock& b = support.blocks[node.begin];
      const Vec3i in_block(lo - corner_of(support, b.code));
      const int n = count_cells(support.masks[b.mask], in_block, int(edge));
      if (n > 0) add({lo, log2, node.begin, node.end, n == edge * edge * edge});
    }
  }
  return result;
}

}  // namespace pvol
