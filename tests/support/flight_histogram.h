// Free flights in bins of equal probability, against the exact optical depth of their ray.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "pvol/track/flight.h"
#include "support/statistics.h"

namespace pvol::test {

inline constexpr std::size_t kBins = 20;

/// `oracle` has optical_depth() of the whole ray and inverse_optical_depth(depth).
class FlightHistogram {
 public:
  template <class Oracle>
  explicit FlightHistogram(const Oracle& oracle) : collides_(-std::expm1(-oracle.optical_depth())) {
    for (std::size_t i = 1; i < kBins; ++i) {
      const double probability = collides_ * double(i) / kBins;
      edges_[i - 1] = oracle.inverse_optical_depth(-std::log1p(-probability));
    }
  }

  void add(const Flight& flight) {
    ++flights_;
    if (!flight.collided) {
      ++counts_[kBins];
    } else {
      const auto bin = std::upper_bound(edges_.begin(), edges_.end(), flight.t) - edges_.begin();
      ++counts_[std::size_t(bin)];
    }
  }

  /// Adds the counts of flights along another ray of the same optical depth: errors of one sign add
  /// up where each ray alone does not show them.
  void add(const FlightHistogram& other) {
    flights_ += other.flights_;
    for (std::size_t i = 0; i <= kBins; ++i) counts_[i] += other.counts_[i];
  }

  /// By the chi-square law, or by the number of collisions where they are few.
  [[nodiscard]] double p_value() const {
    const double n = double(flights_), collisions = n * collides_;
    if (collisions < proof::kLeastExpected * kBins) {
      return proof::poisson_p_value(flights_ - counts_[kBins], collisions);
    }
    std::array<double, kBins + 1> expected;
    expected.fill(collisions / kBins);
    expected[kBins] = n - collisions;
    return proof::counts_p_value(counts_, expected);
  }

 private:
  double collides_;
  std::array<double, kBins - 1> edges_{};
  std::array<std::uint64_t, kBins + 1> counts_{};  // the last: escapes
  std::uint64_t flights_ = 0;
};

}  // namespace pvol::test
