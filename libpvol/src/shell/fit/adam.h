// Gradient ascent with steps scaled by running moments of each coefficient's gradient.
#pragma once

#include <cmath>
#include <vector>

namespace pvol::detail {

/// Based on: Kingma, Ba. Adam: A Method for Stochastic Optimization. ICLR 2015, algorithm 1, with
/// its default decay rates.
class Adam {
 public:
  explicit Adam(std::size_t count) : mean_(count), square_(count) {}

  /// Moves the parameters uphill by about `rate` each.
  void ascend(double* parameters, const double* gradient, double rate) {
    mean_decay_ *= kMeanDecay;
    square_decay_ *= kSquareDecay;
    for (std::size_t i = 0; i < mean_.size(); ++i) {
      mean_[i] += (1 - kMeanDecay) * (gradient[i] - mean_[i]);
      square_[i] += (1 - kSquareDecay) * (gradient[i] * gradient[i] - square_[i]);
      const double spread = std::sqrt(square_[i] / (1 - square_decay_));
      if (spread > 0) parameters[i] += rate * (mean_[i] / (1 - mean_decay_)) / spread;
    }
  }

 private:
  static constexpr double kMeanDecay = 0.9, kSquareDecay = 0.999;
  std::vector<double> mean_, square_;
  double mean_decay_ = 1, square_decay_ = 1;  // powers, for the correction of the start at 0
};

}  // namespace pvol::detail
