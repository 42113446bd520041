// Micro-bounds: bounds on the density of small cubes of cells within a brick, a byte each, for
// deciding tentative collisions without a look-up. Walks do not see them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pvol {

struct BrickField;   // brick_field.h
struct SharedField;  // shared_field.h

/// For every brick of a field, in its order, the bounds of each cube of edge^3 cells: 64 pairs of
/// bytes for edge 2, 512 for single cells. Code c of a brick stands for base + c * step, computed
/// in floats as written. The bounds hold for every density that look-ups compute, rounding
/// included: of bricks of 9^3 samples nearest and trilinear ones (THEORY.md, T3.4), of those of
/// 11^3 tricubic ones (T1.4).
///
/// Plain arrays without pointers or padding: a file may hold both as they are. A decision reads 8
/// bytes of `scales` and 2 of `codes`, whose addresses are known together.
struct MicroBounds {
  struct Scale {
    float base, step;
    friend bool operator==(const Scale&, const Scale&) = default;
  };
  struct Codes {
    std::uint8_t lo, hi;
    friend bool operator==(const Codes&, const Codes&) = default;
  };

  int edge = 0;               ///< of a cube in cells, 1 or 2
  std::vector<Scale> scales;  ///< by brick
  std::vector<Codes> codes;  ///< by brick, then cube (i, j, k) at (i * n + j) * n + k, n = 8 / edge

  [[nodiscard]] std::size_t bytes() const {
    return scales.size() * sizeof(Scale) + codes.size() * sizeof(Codes);
  }
  friend bool operator==(const MicroBounds&, const MicroBounds&) = default;
};

/// Micro-bounds of a field, in parallel; the result does not depend on the number of threads.
/// Throws Error for an edge other than 1 or 2.
[[nodiscard]] MicroBounds build_micro_bounds(const BrickField& field, int edge);
[[nodiscard]] MicroBounds build_micro_bounds(const SharedField& field, int edge);

/// The first brick whose micro-bounds do not hold, if there is one. The number of bricks must be
/// right. Takes about as long as building them.
[[nodiscard]] std::optional<std::uint32_t> find_violation(const MicroBounds& bounds,
                                                          const BrickField& field);

/// Whether these are micro-bounds of this field: right in number, and none but holds. What a reader
/// asks before it trusts a file.
[[nodiscard]] bool hold(const MicroBounds& bounds, const BrickField& field);

}  // namespace pvol
