// Batches of rays in lanes: flights and transmittances, as wide as the machine.
#pragma once

#include <array>

#include "pvol/volume/batch.h"
#include "volume/simd/entering_rays.h"
#include "volume/simd/flight_memory.h"
#include "volume/simd/simd_field.h"

namespace pvol::detail {

/// A batch and where its results go.
struct BatchTask {
  const SimdField& field;
  const VolumeField& volume;  ///< the same one
  const RayBatch& rays;
  const BatchNumbers& numbers;
  double* t = nullptr;       ///< of flights
  float* through = nullptr;  ///< of transmittances
};

/// What a thread keeps between batches. Rays that are under way have slots, as many as fly at once.
struct BatchMemory : FlightMemory {
  struct Slot {
    std::size_t ray;  ///< number in the batch
    double t0, t1;    ///< of the ray's way inside the volume [world length]
    float length;     ///< of it
  };

  EnteringRays entering;
  Records queue{kRayFields, kSlice};  ///< rays that wait to fly
  std::array<Slot, kSlice> slots;
  std::array<std::uint32_t, kSlice> idle;  ///< slots that are free again
  std::uint32_t idle_count = 0, used = 0;  ///< slots from `used` on were never taken

  BatchMemory() : FlightMemory(kRayFields) {}

  void start() { queue.n = 0, idle_count = 0, used = 0; }
  [[nodiscard]] std::uint32_t take_slot() { return idle_count > 0 ? idle[--idle_count] : used++; }
  void free_slot(std::uint32_t slot) { idle[idle_count++] = slot; }
};

/// Each returns the number of bad rays.
using BatchKernel = std::size_t (*)(const BatchTask&, BatchMemory&);
struct BatchKernels {
  BatchKernel flights = nullptr, analog = nullptr, ratio = nullptr;
};

/// Those of an instruction set; null where it was not compiled.
[[nodiscard]] BatchKernels find_batch_kernels(KernelKind kernel);

}  // namespace pvol::detail
