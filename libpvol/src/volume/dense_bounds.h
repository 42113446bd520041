// Bounds of every small cube of a volume in one array, for kernels that follow many rays at once: a
// step is one look-up at a computed place, without a tree to descend.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "pvol/math/pages.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// A word for each cube of 2^3 to 32^3 cells in the box of the support, and for a border around it.
/// Places are counted in cells from the first word's low corner, so that they are never negative;
/// that is `kBorder` cells below the octree's origin along each axis.
///
/// The word of a cube that holds density has the majorant of mu_t [1/world length] in its upper 20
/// bits, those of a float, rounded up; and in its lower 12 the minorant, as a share of that
/// majorant, rounded down. Other words are below kFirstSolid: kOutside, or the log2 of the edge, in
/// cells, of an aligned empty cube around it. The bounds hold for what look-ups compute, rounding
/// and the field's map included (THEORY.md, T2.2).
struct DenseBounds {
  static constexpr int kBorder = 32;                  ///< a multiple of the largest empty cube
  static constexpr int kLargestEmpty = 5;             ///< log2 of its edge
  static constexpr std::uint32_t kOutside = 31;       ///< walks end there
  static constexpr std::uint32_t kShareBits = 0xfff;  ///< of a word: of 2^-12 of the majorant each
  static constexpr std::uint32_t kFirstSolid = kShareBits + 1;

  int shift = 3;                     ///< log2 of the cubes' edge in cells, 1 to 5
  Vec3i size;                        ///< in cubes
  PagedVector<std::uint32_t> word;   ///< of cube (x, y, z) at (x * size.y + y) * size.z + z
  Vec3i leaves;                      ///< the same box in leaves of 8^3 cells
  PagedVector<std::uint32_t> brick;  ///< of leaves likewise, that of those which hold density

  [[nodiscard]] std::uint64_t bytes() const {
    return (word.size() + brick.size()) * sizeof(std::uint32_t);
  }
};

/// The word for these bounds, 0 <= lo <= hi: 0 where hi is.
[[nodiscard]] std::uint32_t pack_bounds(float lo, float hi);

/// What a word of a cube with density stands for.
[[nodiscard]] inline float majorant(std::uint32_t word) {
  return std::bit_cast<float>(word & ~DenseBounds::kShareBits);
}
[[nodiscard]] inline float minorant(std::uint32_t word) {
  return float(word & DenseBounds::kShareBits) * 0x1p-12f * majorant(word);
}

/// Number of words that the field would take, with cubes of this edge.
[[nodiscard]] std::uint64_t count_words(const Octree& tree, int shift = 3);

/// Bounds of a field that is not empty, in parallel. The cubes are those that cost rays least of
/// 2^3 to 8^3 cells and, where codes of samples can decide, of more (THEORY.md, T2.2), unless
/// `shift` says which; those of recipes, and of what moves, have at least 8^3 cells.
[[nodiscard]] DenseBounds make_dense_bounds(const VolumeField& field,
                                            std::optional<int> shift = std::nullopt);

}  // namespace pvol::detail
