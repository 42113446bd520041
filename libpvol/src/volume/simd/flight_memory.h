// What a thread keeps of rays that fly in lanes.
#pragma once

#include <array>
#include <cstdint>

#include "volume/simd/records.h"

namespace pvol::detail {

/// Rays of a queue that fly at once. Queues are taken from their ends, so that they stay short
/// however paths branch.
inline constexpr std::size_t kSlice = 1024;

/// What flights leave behind, and what becomes of it: arrays of kSlice and a register more.
struct Events {
  template <class T>
  using Array = std::array<T, kSlice + kMostLanes>;

  std::size_t n = 0;                 ///< rays that used up their optical depth
  Array<float> x, y, z, left;        ///< where, and the distance that is left
  Array<std::uint32_t> source;       ///< number in the slice
  std::size_t gone = 0;              ///< rays that left
  Array<std::uint32_t> gone_source;  ///< likewise

  // Of decisions, for each event:
  Array<float> mu;  ///< u times the majorant
  Array<std::uint32_t> rng0, rng1, brick, cube, sample;
  std::array<std::uint32_t, kSlice / 4 + 1> real, open;  ///< masks of registers
  std::size_t undecided = 0;
  Array<std::uint32_t> which;  ///< events that need a look-up
  Array<std::uint32_t> at;     ///< their first sample
  Array<float> density;        ///< there, of fields that are looked up one by one
  // In fields that move:
  Array<float> time;                    ///< of the rays, in frames
  std::array<Array<float>, 3> at_rest;  ///< where what is there was at the files' time
};

struct FlightMemory {
  Records flying;                                     ///< a slice
  std::array<Events::Array<float>, 3> step, inverse;  ///< of the flying: cells per world length
  Events events;

  explicit FlightMemory(std::size_t fields) : flying(fields, kSlice) {}
};

}  // namespace pvol::detail
