// When the shutter is open.
#pragma once

#include <algorithm>
#include <cmath>

namespace pvol {

/// In frames, counted from the time of the files: [-0.25, 0.25] is half a frame around it.
struct Shutter {
  double open = 0, close = 0;

  /// Whether pictures show another time than that of the files.
  [[nodiscard]] bool moves() const { return open != 0 || close != 0; }
  /// u in [0, 1] from the opening to the closing.
  [[nodiscard]] double at(double u) const { return open + u * (close - open); }
  /// The longest way from the files' time.
  [[nodiscard]] double farthest() const { return std::max(std::abs(open), std::abs(close)); }
  friend bool operator==(const Shutter&, const Shutter&) = default;
};

}  // namespace pvol
