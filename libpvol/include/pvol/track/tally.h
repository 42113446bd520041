// Counting what a tracker does, at no cost where nobody asks.
#pragma once

#include <cstdint>

namespace pvol {

/// Counts of one kind of flight. Trackers and fields call these at each event.
struct Tally {
  std::uint64_t lookups = 0;  ///< evaluations of the exact density; for `regular`, cells crossed
  /// Comparisons of a tentative collision with bounds: one with the minorant of its segment
  /// (decomposition), one with the micro-bounds at its place (squeeze). A collision that the first
  /// leaves open and that meets the second counts twice.
  std::uint64_t bounds_tests = 0;
  std::uint64_t segments = 0;         ///< segments entered
  std::uint64_t null_collisions = 0;  ///< tentative collisions that were none

  void lookup() { ++lookups; }
  void bounds_test() { ++bounds_tests; }
  void segment() { ++segments; }
  void null_collision() { ++null_collisions; }
  friend bool operator==(const Tally&, const Tally&) = default;
};

/// The same calls, and nothing happens.
struct NoTally {
  static void lookup() {}
  static void bounds_test() {}
  static void segment() {}
  static void null_collision() {}
};

}  // namespace pvol
