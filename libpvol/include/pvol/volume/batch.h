// Batches of rays, for renderers that have many at hand: what sample_flight and
// sample_transmittance (embed.h) answer for one ray, for arrays of them, 4, 8 or 16 in a
// register where the machine and the volume allow.
//
//   const pvol::BatchField field(cloud);  // once
//   const pvol::RayBatch rays{.size = n,
//                             .origins = {o, false, 12, 4},  // rows of 3 floats
//                             .directions = {d, false, 12, 4}};
//   std::vector<double> t(n);
//   sample_flights(field, rays, {.seed = seed, .first = pixel, .sample = sample}, t.data());
//
// Units are those of embed.h: world lengths, directions of any length, t from the ray's origin.
// Volumes are seen at their first place, moving ones at time 0, chromatic ones by the grey
// extinction, of which each channel's is a share.
//
// A ray's result depends on the volume, the kernel, the ray and its random numbers, and on nothing
// else in the batch: neither on its size nor on the order. Kernels of lanes give the same
// bits, but for sse4, which rounds products; the scalar one has random numbers of its own, those of
// the calls of embed.h.
//
// Any number of threads may use a field at once. A thread's first call keeps some 220 KB of its own
// until the thread ends; later calls allocate nothing, however long the batch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "pvol/track/tracker.h"
#include "pvol/volume/kernel.h"

namespace pvol {

struct Volume;  // volume/volume.h

/// N vectors of floats or doubles somewhere in memory: rows, columns, or members of structs. Steps
/// are in bytes and of either sign, or 0, which repeats; nothing need be aligned.
struct VectorArray {
  const void* data;                 ///< x of the first one
  bool doubles;                     ///< else floats
  std::ptrdiff_t stride;            ///< from one vector to the next
  std::ptrdiff_t component_stride;  ///< from x to y, and from y to z
};

/// N numbers likewise; where `data` is null, infinity N times.
struct NumberArray {
  const void* data = nullptr;
  bool doubles = true;
  std::ptrdiff_t stride = 0;
};

/// Rays of the world, from inside the volume or outside. Bad are those with an origin or direction
/// that is not finite, with a direction of 0, with a t_max that is no number, or so far away that
/// the volume's cells cannot say where: they get NaN. A t_max of 0 or less is a ray that ends where
/// it begins.
struct RayBatch {
  std::size_t size;
  VectorArray origins, directions;
  NumberArray t_max{};  ///< how far rays go [world length]
};

/// Random numbers: those of ray i are the stream Rng(seed, streams ? streams[i] : first + i,
/// sample) (math/rng.h).
struct BatchNumbers {
  std::uint64_t seed = 0, first = 0, sample = 0;
  const std::uint64_t* streams = nullptr;
};

namespace detail {
struct BatchFieldData;
}

/// A volume made ready for batches, once: for lanes that takes bounds of each cube in the volume's
/// box, 4 bytes for 2^3 to 32^3 cells, and 4 bytes for each leaf of 8^3. It has a copy of the
/// volume, which shares the samples, so that the volume may go; copies of a field are one field.
class BatchField {
 public:
  /// By the most lanes that serve, or by the kernel named: then throws Error where the machine has
  /// none such, or where lanes do not serve the volume: homogenised nodes, shared samples, what
  /// moves, what is empty, very large or very thick.
  explicit BatchField(const Volume& volume, KernelKind kernel = KernelKind::automatic);
  /// The same of a volume that is shared, not copied. Not null.
  explicit BatchField(std::shared_ptr<const Volume> volume,
                      KernelKind kernel = KernelKind::automatic);

  [[nodiscard]] KernelKind kernel() const;          ///< not automatic
  [[nodiscard]] const std::string& reason() const;  ///< why that one
  [[nodiscard]] std::uint64_t bytes() const;        ///< of its own
  [[nodiscard]] const detail::BatchFieldData& data() const { return *data_; }

 private:
  std::shared_ptr<const detail::BatchFieldData> data_;
};

/// t[i] is the distance of ray i to its next collision, as sample_flight has it, of density mu_t(t)
/// exp(-int_0^t mu_t): infinite where the ray leaves or reaches its t_max, NaN where it is bad.
/// Lanes have it to a few float ulps of the ray's way inside the volume. Returns the number of bad
/// rays. Decomposition tracking (THEORY.md, T3.2).
std::size_t sample_flights(const BatchField& field, const RayBatch& rays,
                           const BatchNumbers& numbers, double* t);

/// through[i] is an unbiased estimate of ray i's transmittance up to its t_max, in [0, 1], NaN
/// where the ray is bad. Returns the number of bad rays. `analog`, 0 or 1, and `ratio` are computed
/// in lanes (THEORY.md, T3.3), the others by the scalar kernel. Throws Error for `automatic`, and
/// for `regular` of volumes that have no closed form; never for rays.
std::size_t sample_transmittances(const BatchField& field, const RayBatch& rays,
                                  const BatchNumbers& numbers, Transmittance estimator,
                                  float* through);

}  // namespace pvol
