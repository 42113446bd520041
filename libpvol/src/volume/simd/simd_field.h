// A volume's field as the lane kernels read it: tables of floats without variants.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "pvol/field/shared_field.h"
#include "pvol/math/rng.h"
#include "pvol/volume/volume.h"
#include "volume/dense_bounds.h"
#include "volume/simd/records.h"

namespace pvol::detail {

/// Refers to bounds and samples, which outlive it.
struct SimdField {
  const DenseBounds& bounds;
  // One of three is not null: what lanes look up, by brick, or what goes lane by lane.
  const float* samples = nullptr;              ///< copies
  const LeafSamples* shared = nullptr;         ///< where samples of others are
  const VolumeField* one_by_one = nullptr;     ///< all other fields
  const FieldMap* map = nullptr;               ///< of densities that lanes look up, or null
  const VolumeField* moving = nullptr;         ///< what moves samples that lanes look up, or null
  const std::uint16_t* micro_codes = nullptr;  ///< pairs of bytes, or null where there are none
  const float* micro_scales = nullptr;         ///< pairs of base and step
  int micro_shift = 0;                         ///< log2 of their cubes' edge
  const std::uint8_t* codes = nullptr;         ///< of samples, or null where there are none
  const float* code_scales = nullptr;          ///< pairs of base and step
  float scale;                                 ///< mu_t of a density of 1 [1/world length]
  LookUp look_up;                              ///< in lanes nearest or trilinear
  /// By axis of the world, the change of the position in cells per unit along it.
  std::array<Vec3f, 3> cells;
  std::size_t step_field = 0;  ///< first of three of records that bring their own steps; 0: none
  std::size_t time_field = 0;  ///< of records that see what moves at a time [frames]; 0: none
  /// The box of the support, in cells from the dense bounds' low corner: rays enter at or above
  /// `low`, and at or below `high`, the last float before its end.
  Vec3f low, high;

  /// Of a field that has no obstacle. `b` are its bounds.
  SimdField(const VolumeField& f, const DenseBounds& b);
};

/// The densities of a field, mapped, at places in cells from the dense bounds' low corner, each in
/// a cell of a brick, or of none (kZeroBrick): what has no look-ups in lanes. Entries `which` of
/// all arrays but the last. `time` is where the field moves, else null.
void look_up_one_by_one(const VolumeField& field, const float* x, const float* y, const float* z,
                        const float* time, const std::uint32_t* brick,
                        std::span<const std::uint32_t> which, float* density);

/// Where the densities at these places were at the files' time, as `to_x`, `to_y` and `to_z`; in
/// the same cells, which a field in motion may have moved by `time` frames.
struct PlacesInMotion {
  const float *x, *y, *z, *time;
  float *to_x, *to_y, *to_z;
};
/// For entries `which` of all arrays.
void trace_back(const VolumeField& field, const PlacesInMotion& places,
                std::span<const std::uint32_t> which);

/// Why lanes do not serve the rays of a volume, at its first place, or null.
[[nodiscard]] const char* simd_obstacle(const Volume& volume);

/// Adds a ray from a place in cells from the octree's origin, which is moved into the box of the
/// support, in a unit direction of the world. Its optical depth and the state of its random numbers
/// are the next of `rng`. Returns the record's number; the record's other fields are the caller's.
inline std::size_t put_ray(const SimdField& f, Records& q, Vec3d place, Vec3f d, Rng& rng) {
  const std::size_t n = q.n++;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = float(place[axis] + double(DenseBounds::kBorder));
    q[kX + std::size_t(axis)][n] = std::clamp(at, f.low[axis], f.high[axis]);
    q[kDX + std::size_t(axis)][n] = d[axis];
  }
  q[kDepth][n] = rng.tentative().depth;
  const Philox::Block state = rng.block();
  q.bits(kRng0)[n] = std::uint32_t(state.lo) | 1;
  q.bits(kRng1)[n] = std::uint32_t(state.hi);
  return n;
}

}  // namespace pvol::detail
