// Sums that do not depend on the order of their terms.
#pragma once

namespace pvol::detail {

/// The sum of floats in two doubles without rounding, as long as terms lie within some 22 decades
/// of each other: paths of a sample that end in another order give the same bytes. Beyond, the
/// error is 2^-104 of the sum. Based on: Knuth. The Art of Computer Programming, volume 2, 4.2.2
/// (the error of a sum is a float); Dekker. A floating-point technique for extending the available
/// precision. 1971.
struct ExactSum {
  double high = 0, low = 0;

  void add(float term) {
    const double t = double(term), sum = high + t, back = sum - high;
    const double error = ((high - (sum - back)) + (t - back)) + low;
    high = sum + error;
    low = error - (high - sum);
  }
  [[nodiscard]] double value() const { return high; }
};

}  // namespace pvol::detail
