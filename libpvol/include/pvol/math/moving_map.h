// Affine maps that change with time: what moves, turns and grows as a whole.
#pragma once

#include <array>
#include <vector>

#include "pvol/math/affine.h"

namespace pvol {

/// The turn about an axis through the origin by an angle, right-handed (Rodrigues' formula).
[[nodiscard]] Affine rotation_about(Vec3d unit_axis, double radians);

/// A turn whose angle grows evenly.
struct MovingTurn {
  Vec3d axis{0, 1, 0};  ///< unit
  double angle = 0;     ///< at time 0, radians
  double rate = 0;      ///< radians a frame
  friend bool operator==(const MovingTurn&, const MovingTurn&) = default;
};

/// At time t, in frames, the linear map L + t L', then the turns in their order, then the
/// translation c + t c' (THEORY.md, T1.7). By default the identity, at rest.
struct MovingMap {
  Affine linear{};                     ///< L; does not move the origin
  std::array<Vec3d, 3> linear_rate{};  ///< L', by rows
  std::vector<MovingTurn> turns{};
  Vec3d shift{}, shift_rate{};  ///< c and c', world units and those a frame

  [[nodiscard]] Affine at(double frames) const;
  /// By how much a place of the map's own frame moves in a frame of the film, at a time: right to
  /// 1e-5 of that for turns of up to one a frame.
  [[nodiscard]] Vec3d velocity(Vec3d place, double frames) const;
  /// Whether it is another map at another time.
  [[nodiscard]] bool moves() const;
  friend bool operator==(const MovingMap&, const MovingMap&) = default;
};

/// Whether the map can be undone, without losing nine digits of its volume, at all times from t0 to
/// t1.
[[nodiscard]] bool stays_regular(const MovingMap& map, double t0, double t1);

}  // namespace pvol
