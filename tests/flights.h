// Rays of known optical depth through test fields, for tests of trackers.
#pragma once

#include <string>
#include <vector>

#include "fields.h"
#include "oracle.h"
#include "pvol/bounds/walk.h"

namespace pvol::test {

inline constexpr std::uint64_t kSeed = 20240229;

/// The exact mu_t that trackers look up.
template <Interpolation kInterpolation>
struct Exact {
  const Volume& volume;
  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return volume.extinction * density<kInterpolation>(volume.field, volume.octree, s.leaf, p);
  }
};

/// Where a walk starts and what it must find there: the oracle's ray is the walk's, to the last
/// bit.
struct Aim {
  Cursor cursor;
  Float4 direction;
  RayOracle oracle;
};

/// Kinds of rays: 0 enters the support from outside, 1 runs along an axis from a face of the
/// support, 2 starts within the density.
inline constexpr int kRays = 3;

/// A ray through density of the field. Lengths are in units that make the optical depth `depth`; 0
/// leaves them in cells.
[[nodiscard]] Aim aim(const Field& field, const Volume& volume, Interpolation interpolation,
                      int kind, double depth);

/// A tracker and a depth at which its walk stops.
struct Choice {
  std::string name;
  Tracker tracker;
  std::optional<int> depth;
};

/// Each tracker with depths 0, 2, 16 and that of the cost model.
[[nodiscard]] const std::vector<Choice>& choices();

/// `f(std::integral_constant<Tracker, tracker>{})`.
template <class F>
auto with_tracker(Tracker tracker, const F& f) {
  switch (tracker) {
    case Tracker::delta_global:
      return f(std::integral_constant<Tracker, Tracker::delta_global>{});
    case Tracker::delta:
      return f(std::integral_constant<Tracker, Tracker::delta>{});
    case Tracker::decomposition:
      break;
  }
  return f(std::integral_constant<Tracker, Tracker::decomposition>{});
}

}  // namespace pvol::test
