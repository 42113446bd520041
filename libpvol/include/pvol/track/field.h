// What trackers ask of a medium, and two models: every question a look-up, or bounds first.
#pragma once

#include <array>
#include <concepts>

#include "pvol/bounds/walk.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/field/micro_range.h"
#include "pvol/field/sample_codes.h"
#include "pvol/track/tally.h"

namespace pvol {

/// The extinction mu_t as trackers see it. `s` is the current segment, `p` a point of it; the
/// calls count what they do.
///   extinction(s, p, count)   the exact mu_t at p [1/world length], not negative: one look-up;
///   exceeds(s, p, mu, count)  whether mu < mu_t(p), exactly as extinction() would say, to the last
///                             bit; a model may know it from bounds alone.
/// Unlike the value, the decision can be had for less: that is why analog trackers ask for it.
template <class F, class Count = NoTally>
concept ExtinctionField = requires(const F& field, const Segment& s, const LatticePoint& p,
                                   float mu, Count& count) {
  { field.extinction(s, p, count) } -> std::same_as<float>;
  { field.exceeds(s, p, mu, count) } -> std::same_as<bool>;
};

/// A field that closed forms can use too. Its `source` knows
///   source.corners(s, cell)  mu_t at the corners of a cell of s, that of (x, y, z) in {0, 1}^3 at
///                            [4x + 2y + z];
/// and Source::kLookUp.
template <class F>
concept CellField = requires(const F& field, const Segment& s, Int4 cell) {
  { field.source.kLookUp } -> std::convertible_to<LookUp>;
  { field.source.corners(s, cell) } -> std::same_as<std::array<float, 8>>;
};

/// Every question is a look-up. `source(s, p)` is mu_t: a BrickExtinction, or any function.
template <class Source>
struct PlainField {
  Source source;

  template <class Count>
  [[nodiscard]] float extinction(const Segment& s, const LatticePoint& p, Count& count) const {
    count.lookup();
    return source(s, p);
  }

  template <class Count>
  [[nodiscard]] bool exceeds(const Segment& s, const LatticePoint& p, float mu,
                             Count& count) const {
    return mu < extinction(s, p, count);
  }
};
template <class Source>
PlainField(Source) -> PlainField<Source>;

/// What decides most tentative collisions before the density is looked up.
enum class Squeeze {
  none,
  micro_bounds,  ///< of small cubes of cells
  codes,         ///< samples as bytes
};

/// What micro-bounds say of a point in a brick.
struct CubeBounds {
  const MicroBounds& bounds;

  [[nodiscard]] DensityRange operator()(std::uint32_t brick, const LatticePoint& p) const {
    return micro_range(bounds, brick, p.cell);
  }
};

/// What the codes of samples say of it.
template <LookUp kLookUp>
struct CodeBounds {
  const SampleCodes& codes;

  [[nodiscard]] DensityRange operator()(std::uint32_t brick, const LatticePoint& p) const {
    return code_range<kLookUp>(codes, brick, p);
  }
};

/// Bounds of the density at the point first, and a look-up only where they leave the decision open
/// (THEORY.md, T3.4 and T3.10). The source is made of bricks, as BrickExtinction is:
/// source.brick(s, p), source.in_brick(brick, p) and source.scale, the factor from density to mu_t.
template <class Bounds, class Source>
struct SqueezedField {
  Source source;
  Bounds bounds;

  template <class Count>
  [[nodiscard]] float extinction(const Segment& s, const LatticePoint& p, Count& count) const {
    count.lookup();
    return source(s, p);
  }

  template <class Count>
  [[nodiscard]] bool exceeds(const Segment& s, const LatticePoint& p, float mu,
                             Count& count) const {
    const std::uint32_t brick = source.brick(s, p);
    count.bounds_test();
    const DensityRange range = bounds(brick, p);
    // Products round monotonically, and the look-up multiplies by the same factor.
    if (mu < source.scale * range.lo) return true;
    if (!(mu < source.scale * range.hi)) return false;
    count.lookup();
    return mu < source.in_brick(brick, p);
  }
};

}  // namespace pvol
