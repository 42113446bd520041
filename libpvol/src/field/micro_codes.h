// From the densities of cubes to micro-bounds: a byte for each end, relative to the brick.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "pvol/field/micro_bounds.h"
#include "pvol/field/micro_range.h"

namespace pvol::detail {

/// The least and the largest density that look-ups can compute in the cubes of a brick.
struct CubeRanges {
  DensityRange all;                                         ///< holds those of all cubes
  std::array<DensityRange, micro_cubes_per_brick(1)> cube;  ///< in the order of the codes
};

/// The densities that float look-ups can compute where exact ones lie in [lo, hi], 0 <= lo: up to
/// `slack` beyond, though never below 0.
[[nodiscard]] DensityRange widened(double lo, double hi, double slack);

/// Ranges of brick b in cubes of `edge` cells, which are written to the last argument.
using RangesOfBrick = std::function<void(std::size_t b, int edge, CubeRanges&)>;

/// In parallel; the result does not depend on the number of threads. Throws Error for an edge other
/// than 1 or 2.
[[nodiscard]] MicroBounds make_micro_bounds(std::size_t bricks, int edge, const RangesOfBrick&);

/// Writes those of brick b; `ranges` is scratch.
void bound_brick(MicroBounds& bounds, std::size_t b, const RangesOfBrick&, CubeRanges& ranges);

/// Makes those of some bricks anew, and room for bricks that are new: those of `bricks`, which are
/// apart, are the ones of a field that changed or came.
void remake_micro_bounds(MicroBounds& bounds, const BrickField& field,
                         std::span<const std::uint32_t> bricks);

/// Whether these are micro-bounds of so many bricks.
[[nodiscard]] bool fit(const MicroBounds& bounds, std::size_t bricks);

/// The first brick for which bounds that fit do not hold.
[[nodiscard]] std::optional<std::uint32_t> find_violation(const MicroBounds& bounds,
                                                          std::size_t bricks, const RangesOfBrick&);

/// Ranges of a brick of 11^3 samples under tricubic look-ups (THEORY.md, T1.4).
void tricubic_ranges(const float* samples, int edge, CubeRanges& ranges);

}  // namespace pvol::detail
