// Rays of known optical depth through test fields, for tests of trackers.
#pragma once

#include <string>
#include <vector>

#include "pvol/bounds/walk.h"
#include "pvol/field/brick_field.h"
#include "pvol/track/field.h"
#include "support/effort.h"
#include "support/fields.h"
#include "support/oracle.h"

namespace pvol::test {

inline const std::uint64_t kSeed = proof::seeded(20240229);

/// The exact mu_t of a volume, every question a look-up.
template <LookUp kLookUp>
[[nodiscard]] auto exact(const Volume& v) {
  return PlainField{
      BrickExtinction<kLookUp>{v.density.bricks(), v.density.octree, v.density.scale}};
}

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
[[nodiscard]] Aim aim(const Field& field, const Volume& volume, LookUp look_up, int kind,
                      double depth);

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
      return f(std::integral_constant<Tracker, Tracker::decomposition>{});
    case Tracker::weighted_delta:
      return f(std::integral_constant<Tracker, Tracker::weighted_delta>{});
    case Tracker::weighted_decomposition:
      return f(std::integral_constant<Tracker, Tracker::weighted_decomposition>{});
    case Tracker::regular:
      break;
  }
  return f(std::integral_constant<Tracker, Tracker::regular>{});
}

}  // namespace pvol::test
