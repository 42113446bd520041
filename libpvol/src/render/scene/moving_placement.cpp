// From two placements to a map that moves.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/render/placement.h"

namespace pvol {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// From a half turn, in radians, to which axes of turns are known.
constexpr double kNearHalf = 1e-6;

Affine transposed(const Affine& a) {
  Affine t;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) t.m[std::size_t(r)][c] = a.m[std::size_t(c)][r];
  }
  return t;
}

std::array<Vec3d, 3> difference(const Affine& a, const Affine& b) {
  return {a.m[0] - b.m[0], a.m[1] - b.m[1], a.m[2] - b.m[2]};
}

/// A linear map as an orthogonal one after a stretch. That is a turn but where the map is mirrored;
/// what leads from one mirrored map to another is a turn all the same.
struct Polar {
  Affine turn, stretch;
};

/// Newton's iteration (Higham. Computing the polar decomposition. 1986), scaled by determinants.
Polar decompose(Affine linear) {
  linear.t = {};
  Affine x = linear;
  for (int i = 0; i < 60; ++i) {
    const Affine other = transposed(inverse(x));
    const double scale = std::cbrt(1 / std::abs(determinant(x)));
    Affine next;
    double change = 0;
    for (std::size_t r = 0; r < 3; ++r) {
      next.m[r] = (x.m[r] * scale + other.m[r] / scale) * 0.5;
      change = std::max(change, length(next.m[r] - x.m[r]));
    }
    x = next;
    if (change < 1e-15) break;
  }
  return {x, transposed(x) * linear};
}

/// The shortest turn from one orientation to another.
MovingTurn shortest_turn(const Affine& from, const Affine& to) {
  const Affine r = to * transposed(from);
  const Vec3d twice_sine(r.m[2].y - r.m[1].z, r.m[0].z - r.m[2].x, r.m[1].x - r.m[0].y);
  const double size = length(twice_sine);
  const double angle = std::atan2(size, r.m[0].x + r.m[1].y + r.m[2].z - 1);
  MovingTurn turn;
  if (!(size > 0)) {
    turn.rate = angle;  // 0, or a half turn, which has no axis here
    return turn;
  }
  turn.axis = twice_sine / size;
  turn.rate = angle;
  return turn;
}

/// Whether the turns of one are those of the other, but for their angles and for turns at the end.
bool same_axes(const std::vector<Turn>& a, const std::vector<Turn>& b) {
  constexpr double kSame = 1e-12;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (length(normalize(a[i].axis) - normalize(b[i].axis)) > kSame) return false;
  }
  return true;
}

std::vector<MovingTurn> turns_of(const std::vector<Turn>& a, const std::vector<Turn>& b) {
  std::vector<MovingTurn> turns;
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    const double from = i < a.size() ? a[i].degrees : 0, to = i < b.size() ? b[i].degrees : 0;
    const Vec3d axis = normalize(i < a.size() ? a[i].axis : b[i].axis);
    turns.push_back({axis, from * kDegree, (to - from) * kDegree});
  }
  return turns;
}

/// Whether angles are what changes, about axes that do not.
bool turns_by_angles(const MovingPlacement& p) {
  return !p.from.matrix && !p.to.matrix && same_axes(p.from.rotate, p.to.rotate);
}

/// As a turn after a stretch, which a placement without a matrix says itself.
Polar parts(const Placement& p, bool by_matrix) {
  if (by_matrix) return decompose(p.map());
  Placement turn;
  turn.rotate = p.rotate;
  return {turn.map(), scaling(p.scale.value_or(Vec3d(1.0)))};
}

Vec3d shift_of(const Placement& p) {
  return p.matrix ? p.matrix->t : p.translate.value_or(Vec3d{});
}

}  // namespace

MovingMap MovingPlacement::map() const {
  MovingMap m;
  m.shift = shift_of(from);
  m.shift_rate = shift_of(to) - m.shift;
  if (turns_by_angles(*this)) {
    m.linear = scaling(from.scale.value_or(Vec3d(1.0)));
    m.linear_rate = difference(scaling(to.scale.value_or(Vec3d(1.0))), m.linear);
    m.turns = turns_of(from.rotate, to.rotate);
    return m;
  }
  const bool by_matrix = from.matrix || to.matrix;
  const Polar first = parts(from, by_matrix), last = parts(to, by_matrix);
  m.linear = first.turn * first.stretch;
  if (from.map().m == to.map().m) return m;  // at rest, whatever the decomposition rounds
  m.linear_rate = difference(first.turn * last.stretch, m.linear);
  m.turns = {shortest_turn(first.turn, last.turn)};
  return m;
}

std::optional<Misfit> misfit(const MovingPlacement& p) {
  if (determinant(p.from.map()) * determinant(p.to.map()) < 0) {
    return Misfit{{"scale", "matrix"},
                  "a placement that mirrors if and only if the first one does"};
  }
  const MovingMap map = p.map();
  if (!turns_by_angles(p) && !map.turns.empty() &&
      std::abs(map.turns.front().rate) > std::numbers::pi - kNearHalf) {
    return Misfit{{"rotate", "matrix"},
                  "a rotation of less than half a turn from the first placement, or degrees about "
                  "the same axes, which determine the way"};
  }
  if (stays_regular(map, 0, 1)) return std::nullopt;
  return Misfit{{"scale", "matrix"},
                "scales with the signs of the first ones, so that none passes 0"};
}

}  // namespace pvol
