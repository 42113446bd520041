// One quadric that is at most 0 on some points and above 0 on as many of others as it can be.
#pragma once

#include <cstdint>

#include "pvol/form/quadric.h"
#include "shell/fit/points.h"

namespace pvol::detail {

/// Where a search starts: a quadric and a ball at whose scale its surface lies; the search runs in
/// the ball's frame.
struct Seed {
  Quadric quadric;
  Vec3d centre;
  double radius = 1;
};

/// How hard a search tries.
struct SearchEffort {
  int iterations = 0;
  int rounds = 0;            ///< of adding points that turned out to be violated, in between
  std::size_t boundary = 0;  ///< points that it looks at besides those
  std::size_t targets = 0;
  double width_begin = 0.5;  ///< of the sigmoid, in radii
  double width_end = 0.08;
  double rate_begin = 0.1;  ///< of Adam
  double rate_end = 0.01;
};

struct Separation {
  Quadric quadric;  ///< <= 0 on all boundary points but for float rounding, and of unit slope
                    ///< where it touches them
  std::size_t removed = 0;  ///< targets where it is above 0
};

/// Maximises sum_t s((Q(t) - max_b Q(b)) / w) over the nine coefficients beside the constant, for a
/// sigmoid s whose width w shrinks, by Adam (Kingma, Ba. 2015) from the seed: THEORY.md, T7.4.
/// `key` selects the random subsets of points. Sequential and deterministic.
[[nodiscard]] Separation separate(const Points& boundary, const Points& targets, const Seed& seed,
                                  const SearchEffort& effort, std::uint64_t key);

}  // namespace pvol::detail
