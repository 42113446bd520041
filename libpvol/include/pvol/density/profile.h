// How density rises with the depth below a cloud's surface.
#pragma once

#include <vector>

#include "pvol/math/interval.h"

namespace pvol {

enum class ProfileKind {
  linear,  ///< clamp(x, 0, 1)
  smooth,  ///< 3t^2 - 2t^3 of that: without creases at both ends
  table    ///< straight lines between points, constant beyond the first and the last
};

struct ProfilePoint {
  double depth = 0;
  double density = 0;
  friend bool operator==(const ProfilePoint&, const ProfilePoint&) = default;
};

/// A function of x = depth / edge, in units of the density deep inside.
struct Profile {
  ProfileKind kind = ProfileKind::linear;
  /// Of a table: two or more, depths ascend strictly, densities are >= 0 and may rise and fall; the
  /// first is 0 and some are not.
  std::vector<ProfilePoint> points;
  friend bool operator==(const Profile&, const Profile&) = default;
};

/// x may be infinite.
[[nodiscard]] double value(const Profile& profile, double x);

/// Holds value(profile, x) for every x in the interval: attained for lines and tables, within a few
/// ulp for the smooth one. Equal ends where it is certainly constant.
[[nodiscard]] Interval range(const Profile& profile, Interval x);

/// The profile is 0 up to this x.
[[nodiscard]] double start(const Profile& profile);

/// Its largest value.
[[nodiscard]] double largest(const Profile& profile);

}  // namespace pvol
