#include "volume/dense_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bounds/octree_children.h"
#include "field/brick_codes.h"
#include "field/micro_codes.h"
#include "pvol/math/parallel.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_range.h"
#include "pvol/math/field_map.h"
#include "volume/field_samples.h"

namespace pvol::detail {
namespace {

constexpr int kFinest = 1, kCoarsest = 3;  // shifts
constexpr std::uint64_t kMostFineWords = 1u << 21;
constexpr std::size_t kGrain = 64;  // bricks of a task
constexpr float kLargest = std::numeric_limits<float>::max();

/// The box that the arrays cover, in cells: the border below, and above the support as much as
/// makes the edge of the largest empty cubes.
Vec3i box_of(const Octree& tree) {
  constexpr int kStep = 1 << DenseBounds::kLargestEmpty;
  return vec3((tree.support_hi + (kStep - 1)) & -kStep) + Vec3i(2 * DenseBounds::kBorder);
}
Vec3i count_along(const Octree& tree, int shift) {
  const Vec3i box = box_of(tree);
  return {box.x >> shift, box.y >> shift, box.z >> shift};
}
std::size_t index_in(Vec3i size, Vec3i at) {
  return (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
         std::size_t(at.z);
}
std::size_t volume_of(Vec3i size) {
  return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
}

/// Densities of the n^3 cubes of a brick, cube (i, j, k) at (i * n + j) * n + k.
struct CubesOfBrick {
  int n;
  std::array<DensityRange, 64> range;
};

/// Calls visit(index, (i, j, k)) for the n^3 cubes of a brick.
template <class Visit>
void for_cubes(int n, const Visit& visit) {
  for (int i = 0, at = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k, ++at) visit(at, Vec3i(i, j, k));
    }
  }
}

/// Those of cubes of twice the edge.
CubesOfBrick coarser(const CubesOfBrick& fine) {
  CubesOfBrick r{fine.n / 2, {}};
  for_cubes(r.n, [&](int at, Vec3i) { r.range[std::size_t(at)] = {kLargest, 0}; });
  for_cubes(fine.n, [&](int at, Vec3i cube) {
    const int parent = ((cube.x >> 1) * r.n + (cube.y >> 1)) * r.n + (cube.z >> 1);
    DensityRange& to = r.range[std::size_t(parent)];
    const DensityRange& from = fine.range[std::size_t(at)];
    to = {std::min(to.lo, from.lo), std::max(to.hi, from.hi)};
  });
  return r;
}

/// What look-ups can compute in the finest cubes of a brick, before the field's map.
void find_ranges(const VolumeField& field, std::uint32_t b, std::array<DensityRange, 64>& range) {
  if (field.look_up == LookUp::tricubic) {
    CubeRanges cubes;
    tricubic_ranges(field.bricks().brick<LookUp::tricubic>(b), 1 << kFinest, cubes);
    std::copy_n(cubes.cube.begin(), range.size(), range.begin());
    return;
  }
  // By codes of samples, which tell the same whether the field has them or not.
  std::array<std::uint8_t, kFieldSamples> own;
  const bool has_codes = field.codes != nullptr;
  SampleCodes::Scale scale;
  if (has_codes) {
    scale = field.codes->scales[b];
  } else {
    std::array<float, kFieldSamples> scratch;
    scale = code_samples(samples_of(field, b, scratch.data()), own.data());
  }
  std::array<CodeRange, 64> codes;
  find_code_ranges(has_codes ? field.codes->of_brick(b) : own.data(), codes);
  for (std::size_t i = 0; i < range.size(); ++i) range[i] = reach_of_codes(scale, codes[i]);
}

/// The same, mapped, in cubes of an edge.
CubesOfBrick cubes_of(const VolumeField& field, std::uint32_t b, int shift) {
  CubesOfBrick r{kLeafEdge >> kFinest, {}};
  find_ranges(field, b, r.range);
  if (field.map != nullptr) {
    for (DensityRange& d : r.range) {
      const ValueRange mapped = range_over(*field.map, {d.lo, d.hi});
      d = {mapped.lo, mapped.hi};
    }
  }
  while (r.n > kLeafEdge >> shift) r = coarser(r);
  return r;
}

/// What rays cost in a leaf of such cubes, up to a factor (THEORY.md, T2.2): steps, by the mean
/// chord of 2/3 of the edge, and tentative collisions, by the majorant. `depth_per_density` is the
/// optical depth of a cell of density 1. Words that caches do not hold make steps dearer.
double cost_of(const CubesOfBrick& cubes, double depth_per_density, std::uint64_t words) {
  constexpr std::uint64_t kCached = 1u << 20;
  constexpr double kTentative = 3;
  const double step = words > kCached ? 1.5 : 1;
  const double edge = double(kLeafEdge) / cubes.n, cells = edge * edge * edge;
  double cost = 0;
  for_cubes(cubes.n, [&](int at, Vec3i) {
    const double hi = double(cubes.range[std::size_t(at)].hi);
    cost += cells * (step / (2.0 / 3.0 * edge) + kTentative * hi * depth_per_density);
  });
  return cost;
}

/// The word of a cube of samples from lo to hi. Look-ups leave their range by 3 ulp at most (T1.2).
std::uint32_t word_of(DensityRange r, float scale) {
  constexpr float kSlack = 0x1p-21f;
  return pack_bounds(scale * r.lo * (1 - kSlack), scale * r.hi * (1 + kSlack));
}

/// Writes the words and bricks of leaves, which have words for n^3 cubes.
struct LeafWords {
  const Octree& tree;
  int n;
  DenseBounds& out;

  /// A leaf, or a uniform cube, as far as it lies in the support.
  void add_cube(Vec3i low, int edge, std::uint32_t brick, const std::uint32_t* words) const {
    const Vec3i end = min(low + Vec3i(edge), vec3(tree.support_hi));
    for (int x = low.x; x < end.x; x += kLeafEdge) {
      for (int y = low.y; y < end.y; y += kLeafEdge) {
        for (int z = low.z; z < end.z; z += kLeafEdge) add_leaf({x, y, z}, brick, words);
      }
    }
  }

  void add_leaf(Vec3i low, std::uint32_t brick, const std::uint32_t* words) const {
    const Vec3i from_border = low + Vec3i(DenseBounds::kBorder);
    const auto along = [&](int shift) {
      return Vec3i(from_border.x >> shift, from_border.y >> shift, from_border.z >> shift);
    };
    out.brick[index_in(out.leaves, along(kCoarsest))] = brick;
    const Vec3i first = along(out.shift);
    for_cubes(n,
              [&](int at, Vec3i cube) { out.word[index_in(out.size, first + cube)] = words[at]; });
  }
};

/// Calls visit(index) for the words of a cube of them, until one call returns false; tells whether
/// all returned true.
template <class Visit>
bool visit_cube(const DenseBounds& b, Vec3i first, int edge, const Visit& visit) {
  for (int x = first.x; x < first.x + edge; ++x) {
    for (int y = first.y; y < first.y + edge; ++y) {
      const std::size_t row = index_in(b.size, {x, y, first.z});
      for (std::size_t i = row; i < row + std::size_t(edge); ++i) {
        if (!visit(i)) return false;
      }
    }
  }
  return true;
}

/// Gives the words of an aligned cube the largest empty cubes that there are in it.
void mark_empty(DenseBounds& b, Vec3i first, int log2) {
  const int edge = 1 << (log2 - b.shift);
  if (visit_cube(b, first, edge, [&](std::size_t i) { return b.word[i] == 0; })) {
    visit_cube(b, first, edge,
               [&](std::size_t i) { return b.word[i] = std::uint32_t(log2), true; });
  } else if (log2 > b.shift) {
    for (int child = 0; child < 8; ++child) {
      const Vec3i step(child >> 2, child >> 1 & 1, child & 1);
      mark_empty(b, first + step * (edge / 2), log2 - 1);
    }
  }
}

/// Fills what is outside the support's box with kOutside, and empty cubes in it.
void fill_rest(const Octree& tree, DenseBounds& b) {
  const int step = 1 << (DenseBounds::kLargestEmpty - b.shift);
  const Vec3i border(DenseBounds::kBorder >> b.shift);
  const Vec3i low = vec3(tree.support_lo >> b.shift) + border;
  const Vec3i high = vec3((tree.support_hi - 1) >> b.shift) + border;
  parallel_for(0, std::size_t(b.size.x / step), [&](std::size_t block) {
    const int x = int(block) * step;
    for (int y = 0; y < b.size.y; y += step) {
      for (int z = 0; z < b.size.z; z += step) mark_empty(b, {x, y, z}, DenseBounds::kLargestEmpty);
    }
    for (int i = x; i < x + step; ++i) {
      for (int y = 0; y < b.size.y; ++y) {
        const auto row = b.word.begin() + std::ptrdiff_t(index_in(b.size, {i, y, 0}));
        const bool beside = i < low.x || i > high.x || y < low.y || y > high.y;
        std::fill(row, row + (beside ? b.size.z : low.z), DenseBounds::kOutside);
        if (!beside) std::fill(row + high.z + 1, row + b.size.z, DenseBounds::kOutside);
      }
    }
  });
}

/// How many leaves have each brick.
std::vector<std::uint32_t> count_leaves(const VolumeField& field) {
  std::vector<std::uint32_t> leaves(count_bricks(field));
  const Octree& tree = field.octree;
  for_bricks(tree, tree.nodes[0], {}, [&](Vec3i, int edge, std::uint32_t brick) {
    const auto along = std::uint32_t(edge / kLeafEdge);
    if (brick != kZeroBrick) leaves[brick] += along * along * along;
  });
  return leaves;
}

/// The edge of cubes that costs rays least.
int choose_shift(const VolumeField& field) {
  int finest = kFinest;
  while (finest < kCoarsest && count_words(field.octree, finest) > kMostFineWords) ++finest;
  if (finest == kCoarsest) return finest;
  const double cell = std::cbrt(std::abs(determinant(inverse(field.world_to_cells))));
  const double depth = double(field.scale) * cell;
  constexpr std::size_t kShifts = std::size_t(kCoarsest) + 1;
  std::array<std::uint64_t, kShifts> words{};
  for (std::size_t shift = std::size_t(finest); shift < kShifts; ++shift) {
    words[shift] = count_words(field.octree, int(shift));
  }
  using Costs = std::array<double, kShifts>;
  const std::vector<std::uint32_t> leaves = count_leaves(field);
  std::vector<Costs> of_bricks(leaves.size());
  parallel_parts(0, leaves.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b != end; ++b) {
      if (leaves[b] == 0) continue;
      CubesOfBrick cubes = cubes_of(field, std::uint32_t(b), finest);
      for (auto shift = std::size_t(finest);; cubes = coarser(cubes)) {
        of_bricks[b][shift] = double(leaves[b]) * cost_of(cubes, depth, words[shift]);
        if (++shift == kShifts) break;
      }
    }
  });
  Costs sum{};
  for (const Costs& costs : of_bricks) {
    for (std::size_t shift = 0; shift < sum.size(); ++shift) sum[shift] += costs[shift];
  }
  auto best = std::size_t(finest);
  for (std::size_t shift = best + 1; shift < kShifts; ++shift) {
    if (sum[shift] <= sum[best]) best = shift;
  }
  return int(best);
}

/// Whether samples do not tell the densities of a leaf, but the octree alone: there are none, or
/// what is there came from elsewhere.
bool is_bounded_by_tree(const VolumeField& f) {
  return f.look_up == LookUp::procedural || f.motion != nullptr;
}

/// Words of leaves by the bounds of the octree.
void add_words_of_tree(const VolumeField& field, DenseBounds& b) {
  const Octree& tree = field.octree;
  b.shift = kCoarsest;
  b.size = count_along(tree, b.shift);
  b.word.assign(volume_of(b.size), 0);
  LeafWords words{tree, 1, b};
  for_leaves(tree, tree.nodes[0], {}, [&](Vec3i low, int edge, const Octree::Entry& e) {
    const std::uint32_t word = word_of({e.lo / field.scale, e.hi / field.scale}, field.scale);
    words.add_cube(low, edge, e.link, &word);
  });
}

/// Words of cubes in leaves by the samples of their bricks.
void add_words_of_bricks(const VolumeField& field, std::optional<int> shift, DenseBounds& b) {
  const Octree& tree = field.octree;
  b.shift = shift ? *shift : choose_shift(field);
  b.size = count_along(tree, b.shift);
  b.word.assign(volume_of(b.size), 0);
  struct Cube {
    Vec3i low;
    int edge;
    std::uint32_t brick;
  };
  std::vector<Cube> all;
  for_bricks(tree, tree.nodes[0], {}, [&](Vec3i low, int edge, std::uint32_t brick) {
    if (brick != kZeroBrick) all.push_back({low, edge, brick});
  });
  LeafWords words{tree, kLeafEdge >> b.shift, b};
  parallel_parts(0, all.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      const CubesOfBrick cubes = cubes_of(field, all[i].brick, b.shift);
      std::array<std::uint32_t, 64> of_cubes;
      for_cubes(cubes.n, [&](int at, Vec3i) {
        of_cubes[std::size_t(at)] = word_of(cubes.range[std::size_t(at)], field.scale);
      });
      words.add_cube(all[i].low, all[i].edge, all[i].brick, of_cubes.data());
    }
  });
}

}  // namespace

std::uint32_t pack_bounds(float lo, float hi) {
  if (!(hi > 0)) return 0;
  const std::uint32_t kShare = DenseBounds::kShareBits;
  const std::uint32_t up = (std::bit_cast<std::uint32_t>(hi) + kShare) & ~kShare;
  const double share = double(lo) / double(std::bit_cast<float>(up));
  return up | std::min(std::uint32_t(share * (kShare + 1)), kShare);
}

std::uint64_t count_words(const Octree& tree, int shift) {
  return volume_of(count_along(tree, shift));
}

DenseBounds make_dense_bounds(const VolumeField& field, std::optional<int> shift) {
  const Octree& tree = field.octree;
  DenseBounds b;
  b.leaves = count_along(tree, kCoarsest);
  b.brick.assign(volume_of(b.leaves), kZeroBrick);
  if (is_bounded_by_tree(field)) {
    add_words_of_tree(field, b);
  } else {
    add_words_of_bricks(field, shift, b);
  }
  fill_rest(tree, b);
  return b;
}

}  // namespace pvol::detail
