// Look-ups of densities in lanes: of samples in copies of bricks, and of those that stay where
// somebody has them.

#if defined(PVOL_LANE_LOOK_UP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_LOOK_UP_INL_H
#undef PVOL_LANE_LOOK_UP_INL_H
#else
#define PVOL_LANE_LOOK_UP_INL_H
#endif

#include <array>

#include "pvol/field/brick_field.h"
#include "pvol/field/shared_field.h"
#include "volume/simd/flights-inl.h"
#include "volume/simd/map-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

HWY_INLINE void prefetch(const void* p) { __builtin_prefetch(p, 0, 3); }

HWY_INLINE I index_in_cube(I x, I y, I z, int edge) {
  return (x * splat_int(edge) + y) * splat_int(edge) + z;
}

/// The cells of places, counted from the low corners of their leaves.
struct CellInLeaf {
  I x, y, z;

  HWY_INLINE explicit CellInLeaf(const Place& p) : CellInLeaf(p.x, p.y, p.z) {}
  HWY_INLINE CellInLeaf(I px, I py, I pz)
      : x(px & splat_int(kLeafEdge - 1)),
        y(py & splat_int(kLeafEdge - 1)),
        z(pz & splat_int(kLeafEdge - 1)) {}

  /// The indices of their low corners' samples among the copies of bricks, and of codes.
  [[nodiscard]] HWY_INLINE I first_sample(I brick) const {
    return brick * splat_int(kFieldSamples) + index_in_cube(x, y, z, kFieldEdge);
  }
  /// By what look-ups find the cells' samples: the same, or where these are shared, the brick and
  /// the cell in it, whose 9 bits are the lowest.
  [[nodiscard]] HWY_INLINE I samples(const SimdField& f, I brick) const {
    if (f.shared == nullptr) return first_sample(brick);
    return hn::ShiftLeft<9>(brick) + index_in_cube(x, y, z, kLeafEdge);
  }
};

/// From a cell's first sample to that of the corner nearest to a place in the cell.
HWY_INLINE I nearest_corner(F x, F y, F z, std::array<int, 3> stride) {
  const auto step = [](F f, int by) { return where(hn::Ge(f, splat(0.5f)), splat_int(by)); };
  return step(x, stride[0]) + step(y, stride[1]) + step(z, stride[2]);
}

/// Fetches the codes around a cell.
HWY_INLINE void prefetch_cell(const std::uint8_t* first) {
  constexpr int kY = kFieldEdge, kX = kFieldEdge * kFieldEdge;
  prefetch(first), prefetch(first + kY + 1), prefetch(first + kX), prefetch(first + kX + kY + 1);
}

/// Fetches the samples around a cell.
HWY_INLINE void prefetch_cell(const float* first) {
  constexpr int kY = kFieldEdge, kX = kFieldEdge * kFieldEdge;
  prefetch(first), prefetch(first + kY), prefetch(first + kX), prefetch(first + kX + kY);
}

/// Fetches what a look-up reads, or where samples are shared, what says where they are.
HWY_INLINE void prefetch_samples(const SimdField& f, std::uint32_t samples) {
  if (f.shared == nullptr) return prefetch_cell(f.samples + samples);
  prefetch(f.shared + (samples >> 9));
}

/// The value at places in cells, as density_in_brick rounds it; corner(4x + 2y + z) are the values
/// at their corners.
template <class Corner>
HWY_INLINE F interpolate(const Corner& corner, F x, F y, F z) {
  const auto lerp = [](F a, F b, F t) { return a + (b - a) * t; };
  const auto row = [&](int low) { return lerp(corner(low), corner(low + 1), z); };
  return lerp(lerp(row(0), row(2), y), lerp(row(4), row(6), y), x);
}

/// Density at places in cells whose first samples are at `index`.
template <LookUp kLookUp>
HWY_INLINE F look_up(const float* samples, I index, F x, F y, F z) {
  constexpr int kY = kFieldEdge, kX = kFieldEdge * kFieldEdge;
  if constexpr (kLookUp == LookUp::nearest) {
    return gather(samples, index + nearest_corner(x, y, z, {kX, kY, 1}));
  } else {
    const auto corner = [&](int k) {
      return gather(samples + (k >> 2) * kX + (k >> 1 & 1) * kY + (k & 1), index);
    };
    return interpolate(corner, x, y, z);
  }
}

/// Where a sample is, of a leaf's 9^3.
[[nodiscard]] HWY_INLINE const float* place_of(const LeafSamples& leaf, std::uint32_t x,
                                               std::uint32_t y, std::uint32_t z) {
  constexpr std::uint32_t kMask = kBrickEdge - 1;
  const std::uint32_t block = (x >> 3) * 4 + (y >> 3) * 2 + (z >> 3);
  return leaf.block[block] + (((x & kMask) * 8 + (y & kMask)) * 8 + (z & kMask));
}

/// Copies the samples at the corners of a cell of a leaf, each to a lane of its own register.
HWY_INLINE void read_corners(const LeafSamples& leaf, std::uint32_t cell, float* to) {
  const std::uint32_t x = cell >> 6, y = cell >> 3 & 7, z = cell & 7;
  for (std::uint32_t k = 0; k < 8; ++k)
    to[k * kLanes] = *place_of(leaf, x + (k >> 2), y + (k >> 1 & 1), z + (k & 1));
}

/// Density at places in cells of leaves whose samples lie all over memory: lanes read them one by
/// one, and interpolate together. `number` is that of CellInLeaf::samples.
template <LookUp kLookUp>
HWY_NOINLINE F look_up_shared(const LeafSamples* leaves, I number, F x, F y, F z) {
  alignas(64) std::uint32_t cells[kLanes], corner[kLanes];
  alignas(64) float values[8 * kLanes];
  store(as_bits(number), cells);
  if constexpr (kLookUp == LookUp::nearest) {
    store(as_bits(nearest_corner(x, y, z, {1 << 6, 1 << 3, 1})), corner);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t cell = cells[lane], step = corner[lane];
      values[lane] = *place_of(leaves[cell >> 9], (cell >> 6 & 7) + (step >> 6),
                               (cell >> 3 & 7) + (step >> 3 & 1), (cell & 7) + (step & 1));
    }
    return load(values);
  } else {
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      read_corners(leaves[cells[lane] >> 9], cells[lane] & 511, values + lane);
    return interpolate([&](int k) { return load(values + std::size_t(k) * kLanes); }, x, y, z);
  }
}

/// What look-ups of the field compute in the chosen lanes, without its scale. `index` is that of
/// CellInLeaf::samples; in other lanes 0.
template <LookUp kLookUp>
HWY_INLINE F look_up(const SimdField& f, M on, I index, F x, F y, F z) {
  const F density = f.shared == nullptr ? look_up<kLookUp>(f.samples, index, x, y, z)
                                        : look_up_shared<kLookUp>(f.shared, index, x, y, z);
  return f.map == nullptr ? density : value_in_lanes(*f.map, density, on);
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
