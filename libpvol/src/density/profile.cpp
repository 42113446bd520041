#include "pvol/density/profile.h"

#include <algorithm>

namespace pvol {
namespace {

// t t (3 - 2t) is rounded three times by 2^-53 at most: once for the end of the interval, once for
// the values that are compared with it, and some for the rounding of the margin.
constexpr double kSmoothError = 0x1p-50;

double smooth(double t) { return std::min(1.0, t * t * (3 - 2 * t)); }

Interval smooth(Interval t) {
  if (t.lo == t.hi) return smooth(t.lo);
  return {smooth(t.lo) * (1 - kSmoothError), std::min(1.0, smooth(t.hi) * (1 + kSmoothError))};
}

/// Monotone between two points, also as computed: each operation is, and the ends are held.
double look_up(const std::vector<ProfilePoint>& points, double x) {
  if (x <= points.front().depth) return points.front().density;
  if (x >= points.back().depth) return points.back().density;
  const auto above = std::upper_bound(points.begin(), points.end(), x,
                                      [](double v, const ProfilePoint& p) { return v < p.depth; });
  const ProfilePoint& a = *(above - 1);
  const ProfilePoint& b = *above;
  const double slope = (b.density - a.density) / (b.depth - a.depth);
  const auto [least, most] = std::minmax(a.density, b.density);
  return std::clamp(a.density + (x - a.depth) * slope, least, most);
}

Interval clamp_unit(Interval x) { return {std::clamp(x.lo, 0.0, 1.0), std::clamp(x.hi, 0.0, 1.0)}; }

}  // namespace

double value(const Profile& profile, double x) {
  switch (profile.kind) {
    case ProfileKind::linear:
      return std::clamp(x, 0.0, 1.0);
    case ProfileKind::smooth:
      return smooth(std::clamp(x, 0.0, 1.0));
    case ProfileKind::table:
      break;
  }
  return look_up(profile.points, x);
}

Interval range(const Profile& profile, Interval x) {
  if (profile.kind == ProfileKind::linear) return clamp_unit(x);
  if (profile.kind == ProfileKind::smooth) return smooth(clamp_unit(x));
  Interval all = hull(look_up(profile.points, x.lo), look_up(profile.points, x.hi));
  for (const ProfilePoint& p : profile.points) {
    if (x.contains(p.depth)) all = hull(all, p.density);
  }
  return all;
}

double start(const Profile& profile) {
  if (profile.kind != ProfileKind::table) return 0;
  const auto risen = std::find_if(profile.points.begin(), profile.points.end(),
                                  [](const ProfilePoint& p) { return p.density > 0; });
  return risen == profile.points.begin() ? risen->depth : (risen - 1)->depth;
}

double largest(const Profile& profile) {
  if (profile.kind != ProfileKind::table) return 1;
  double most = 0;
  for (const ProfilePoint& p : profile.points) most = std::max(most, p.density);
  return most;
}

}  // namespace pvol
