// Deterministic subsets of numbered things, and where points lie.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pvol/math/direction.h"
#include "pvol/math/rng.h"
#include "shell/fit/points.h"

namespace pvol::detail {

/// `count` of the numbers 0 to n - 1, or all, ascending: one at random from each of as many equal
/// runs.
[[nodiscard]] inline std::vector<std::uint32_t> spread(std::size_t n, std::size_t count,
                                                       std::uint64_t key) {
  count = std::min(count, n);
  std::vector<std::uint32_t> chosen(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t begin = k * n / count, end = (k + 1) * n / count;
    chosen[k] = std::uint32_t(begin + mix64(mix64(key) + k) % (end - begin));
  }
  return chosen;
}

[[nodiscard]] inline Points thinned(const Points& all, std::size_t most, std::uint64_t key) {
  Points few;
  for (const std::uint32_t i : spread(all.size(), most, key)) few.add(all[i]);
  return few;
}

/// The centre of some points and the radius of a ball about it that holds most of them.
struct Cluster {
  std::size_t count = 0;
  Vec3d sum, squares;

  void add(Vec3d p) {
    ++count;
    sum += p;
    squares += p * p;
  }
  [[nodiscard]] Vec3d centre() const { return sum / double(count); }
  [[nodiscard]] double radius(double least) const {
    const Vec3d variance = squares / double(count) - centre() * centre();
    return std::max(least, 1.5 * std::sqrt(std::max(0.0, variance.x + variance.y + variance.z)));
  }
};

}  // namespace pvol::detail
