// Phase functions that lanes have no code of their own for: the lanes of a register, one by one.
#pragma once

#include <cstdint>
#include <span>

#include "render/path/path_setup.h"
#include "volume/simd/records.h"

namespace pvol::detail {

struct PhaseBatch {
  alignas(64) float from[3][kMostLanes];
  alignas(64) float to[3][kMostLanes];
  alignas(64) float pdf[kMostLanes];
  alignas(64) float u[kMostLanes];
  alignas(64) float azimuth[kMostLanes];
  alignas(64) std::uint32_t component[kMostLanes];  ///< the component's number
};

// Compiled once for all instruction sets.

/// Sets `pdf` of the first `count` lanes.
void find_densities(std::span<const MediumComponent> all, std::size_t count, PhaseBatch& lanes);

/// Sets `to` and `pdf`, by `u` and `azimuth`.
void sample_directions(std::span<const MediumComponent> all, std::size_t count, PhaseBatch& lanes);

}  // namespace pvol::detail
