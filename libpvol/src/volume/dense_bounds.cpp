#include "volume/dense_bounds.h"

#include <algorithm>

#include "bounds/octree_children.h"
#include "math/parallel.h"
#include "pvol/field/brick_field.h"

namespace pvol::detail {
namespace {

constexpr int kBorderLeaves = DenseBounds::kBorder / kLeafEdge;

/// Leaves of the box that the array covers: the border below, and above the support as much as
/// makes the edge of the largest empty cubes.
Vec3i leaves(const Octree& tree) {
  constexpr int kStep = 1 << DenseBounds::kLargestEmpty;
  const Vec3i end =
      vec3((tree.support_hi + (kStep - 1)) & -kStep) + Vec3i(2 * DenseBounds::kBorder);
  return {end.x / kLeafEdge, end.y / kLeafEdge, end.z / kLeafEdge};
}

/// The word of a brick of samples from lo to hi. Look-ups leave their range by 3 ulp at most
/// (T1.2).
std::uint32_t word_of(float lo, float hi, float scale) {
  constexpr float kSlack = 0x1p-21f;
  return pack_bounds(scale * lo * (1 - kSlack), scale * hi * (1 + kSlack));
}

std::vector<std::uint32_t> brick_words(const BrickField& field, float scale) {
  std::vector<std::uint32_t> words(field.bricks());
  parallel_for(0, words.size(), [&](std::size_t b) {
    const float* const samples = field.brick(std::uint32_t(b));
    const auto [lo, hi] = std::minmax_element(samples, samples + kFieldSamples);
    words[b] = word_of(*lo, *hi, scale);
  });
  return words;
}

/// Writes the words of leaves.
struct LeafWords {
  const Octree& tree;
  const std::vector<std::uint32_t>& of_brick;
  DenseBounds& out;

  /// A leaf, or a uniform cube, as far as it lies in the support.
  void add_cube(Vec3i low, int edge, std::uint32_t brick) {
    if (of_brick[brick] == 0) return;
    const Vec3i end = min(low + Vec3i(edge), vec3(tree.support_hi));
    for (int x = low.x; x < end.x; x += kLeafEdge) {
      for (int y = low.y; y < end.y; y += kLeafEdge) {
        for (int z = low.z; z < end.z; z += kLeafEdge) {
          const Vec3i leaf(x / kLeafEdge, y / kLeafEdge, z / kLeafEdge);
          const std::size_t i = out.index(leaf + Vec3i(kBorderLeaves));
          out.word[i] = of_brick[brick];
          out.brick[i] = brick;
        }
      }
    }
  }
};

/// Calls visit(index) for the leaves of a cube.
template <class Visit>
void visit_cube(const DenseBounds& b, Vec3i first, int edge, const Visit& visit) {
  for (int x = first.x; x < first.x + edge; ++x) {
    for (int y = first.y; y < first.y + edge; ++y) {
      for (int z = first.z; z < first.z + edge; ++z) visit(b.index({x, y, z}));
    }
  }
}

/// Gives the leaves of an aligned cube the largest empty cubes that there are in it.
void mark_empty(DenseBounds& b, Vec3i first, int log2) {
  const int edge = 1 << (log2 - 3);
  bool empty = true;
  visit_cube(b, first, edge, [&](std::size_t i) { empty = empty && b.word[i] == 0; });
  if (empty) {
    visit_cube(b, first, edge, [&](std::size_t i) { b.word[i] = std::uint32_t(log2); });
  } else if (log2 > 3) {
    for (int child = 0; child < 8; ++child) {
      const Vec3i step(child >> 2, child >> 1 & 1, child & 1);
      mark_empty(b, first + step * (edge / 2), log2 - 1);
    }
  }
}

/// Fills what is outside the support's box with kOutside, and empty leaves in it.
void fill_rest(const Octree& tree, DenseBounds& b) {
  constexpr int kStep = 1 << (DenseBounds::kLargestEmpty - 3);
  const Vec3i low = vec3(tree.support_lo >> 3) + Vec3i(kBorderLeaves);
  const Vec3i high = vec3((tree.support_hi - 1) >> 3) + Vec3i(kBorderLeaves);
  const auto blocks = [&](int leaves) { return std::size_t(leaves / kStep); };
  parallel_for(0, blocks(b.size.x), [&](std::size_t block) {
    const int x = int(block) * kStep;
    for (int y = 0; y < b.size.y; y += kStep) {
      for (int z = 0; z < b.size.z; z += kStep)
        mark_empty(b, {x, y, z}, DenseBounds::kLargestEmpty);
    }
    for (int i = x; i < x + kStep; ++i) {
      for (int y = 0; y < b.size.y; ++y) {
        for (int z = 0; z < b.size.z; ++z) {
          const Vec3i at(i, y, z);
          if (max(at, low) != at || min(at, high) != at)
            b.word[b.index(at)] = DenseBounds::kOutside;
        }
      }
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

std::uint64_t count_words(const Octree& tree) {
  const Vec3l n(leaves(tree));
  return std::uint64_t(n.x) * std::uint64_t(n.y) * std::uint64_t(n.z);
}

DenseBounds make_dense_bounds(const VolumeField& field) {
  const Octree& tree = field.octree;
  DenseBounds b;
  b.size = leaves(tree);
  b.word.assign(count_words(tree), 0);
  b.brick.assign(b.word.size(), kZeroBrick);
  const std::vector<std::uint32_t> of_brick = brick_words(field.bricks(), field.scale);
  for_bricks(tree, tree.nodes[0], {}, [&](Vec3i low, int edge, std::uint32_t brick) {
    LeafWords{tree, of_brick, b}.add_cube(low, edge, brick);
  });
  fill_rest(tree, b);
  return b;
}

}  // namespace pvol::detail
