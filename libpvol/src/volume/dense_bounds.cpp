#include "volume/dense_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bounds/octree_children.h"
#include "pvol/field/brick_field.h"
#include "pvol/math/parallel.h"
#include "volume/brick_cubes.h"
#include "volume/field_samples.h"

namespace pvol::detail {
namespace {

constexpr int kLeaf = 3, kCoarsest = 5;  // shifts
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

/// What rays cost in cubes of an edge, up to a factor (THEORY.md, T2.2): steps, by the mean chord
/// of 2/3 of the edge, and tentative collisions, by the majorant.
class CubeCost {
 public:
  /// Words that caches do not hold make steps dearer.
  CubeCost(const Octree& tree, int shift) : cells_(std::ldexp(1.0, 3 * shift)) {
    constexpr std::uint64_t kCached = 1u << 20;
    const double step = count_words(tree, shift) > kCached ? 1.5 : 1;
    steps_ = step / (2.0 / 3.0 * std::ldexp(1.0, shift));
  }

  /// With a majorant of so much optical depth in a cell.
  [[nodiscard]] double operator()(double depth) const {
    constexpr double kTentative = 3;
    return cells_ * (steps_ + kTentative * depth);
  }

 private:
  double cells_, steps_;
};

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
    out.brick[index_in(out.leaves, along(kLeaf))] = brick;
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

/// The length of a cell's edge, of cells that are no cubes about that of their volume's.
double cell_length(const VolumeField& field) {
  return std::cbrt(std::abs(determinant(inverse(field.world_to_cells))));
}

/// The edge of cubes, of those within leaves, that costs rays least.
int choose_shift(const VolumeField& field) {
  int finest = kFinestCubes;
  while (finest < kLeaf && count_words(field.octree, finest) > kMostFineWords) ++finest;
  if (finest == kLeaf) return finest;
  const double depth = double(field.scale) * cell_length(field);
  constexpr std::size_t kShifts = std::size_t(kLeaf) + 1;
  std::vector<CubeCost> cost;
  for (int shift = 0; shift <= kLeaf; ++shift) cost.emplace_back(field.octree, shift);
  using Costs = std::array<double, kShifts>;
  const std::vector<std::uint32_t> leaves = count_leaves(field);
  std::vector<Costs> of_bricks(leaves.size());
  parallel_parts(0, leaves.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b != end; ++b) {
      if (leaves[b] == 0) continue;
      BrickCubes cubes = cubes_of(field, std::uint32_t(b), finest);
      for (auto shift = std::size_t(finest);; cubes = coarser(cubes)) {
        double sum = 0;
        for_cubes(cubes.n, [&](int at, Vec3i) {
          sum += cost[shift](double(cubes.range[std::size_t(at)].hi) * depth);
        });
        of_bricks[b][shift] = double(leaves[b]) * sum;
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
  b.shift = kLeaf;
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
  b.shift = shift ? std::min(*shift, kLeaf) : choose_shift(field);
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
      const BrickCubes cubes = cubes_of(field, all[i].brick, b.shift);
      std::array<std::uint32_t, 64> of_cubes;
      for_cubes(cubes.n, [&](int at, Vec3i) {
        of_cubes[std::size_t(at)] = word_of(cubes.range[std::size_t(at)], field.scale);
      });
      words.add_cube(all[i].low, all[i].edge, all[i].brick, of_cubes.data());
    }
  });
}

/// The word of eight cubes: of a part that is empty the density is 0.
std::uint32_t join(const std::array<std::uint32_t, 8>& words) {
  float lo = kLargest, hi = 0;
  for (const std::uint32_t word : words) {
    lo = std::min(lo, word == 0 ? 0 : minorant(word));
    hi = std::max(hi, word == 0 ? 0 : majorant(word));
  }
  return pack_bounds(lo, hi);
}

/// The words of cubes of twice the edge.
PagedVector<std::uint32_t> coarser_words(const Octree& tree, const DenseBounds& b) {
  const Vec3i size = count_along(tree, b.shift + 1);
  PagedVector<std::uint32_t> words(volume_of(size));
  parallel_for(0, std::size_t(size.x), [&](std::size_t x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        std::array<std::uint32_t, 8> parts;
        for (int k = 0; k < 8; ++k) {
          const Vec3i at = Vec3i(int(x), y, z) * 2 + Vec3i(k >> 2, k >> 1 & 1, k & 1);
          parts[std::size_t(k)] = b.word[index_in(b.size, at)];
        }
        words[index_in(size, {int(x), y, z})] = join(parts);
      }
    }
  });
  return words;
}

/// What rays cost among such words, of cubes of this edge.
double cost_of(const PagedVector<std::uint32_t>& words, const VolumeField& field, int shift) {
  const CubeCost cost(field.octree, shift);
  const double length = cell_length(field);
  double sum = 0;
  for (const std::uint32_t word : words) {
    if (word != 0) sum += cost(double(majorant(word)) * length);
  }
  return sum;
}

/// Whether codes of samples can decide, which makes tentative collisions cheap. Bounds are the same
/// where the field has none, so that codes change no picture.
bool may_have_codes(const VolumeField& f) {
  return has_closed_form(f.look_up) && f.map == nullptr && f.motion == nullptr;
}

/// Goes on to larger cubes than leaves, up to `shift` or as long as they cost rays less.
void coarsen(const VolumeField& field, std::optional<int> shift, DenseBounds& b) {
  if (b.shift < kLeaf || (!shift && !may_have_codes(field))) return;
  double least = cost_of(b.word, field, b.shift);
  while (b.shift < shift.value_or(kCoarsest)) {
    PagedVector<std::uint32_t> words = coarser_words(field.octree, b);
    const double cost = cost_of(words, field, b.shift + 1);
    if (!shift && cost > least) break;
    least = cost;
    b.word = std::move(words);
    b.size = count_along(field.octree, ++b.shift);
  }
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
  b.leaves = count_along(tree, kLeaf);
  b.brick.assign(volume_of(b.leaves), kZeroBrick);
  if (is_bounded_by_tree(field)) {
    add_words_of_tree(field, b);
  } else {
    add_words_of_bricks(field, shift, b);
  }
  coarsen(field, shift, b);
  fill_rest(tree, b);
  return b;
}

}  // namespace pvol::detail
