// The box around what is to be lit, as lights see it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "math/philox.h"
#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "pvol/math/direction.h"

namespace pvol::detail {

/// Directions around an axis.
struct Cap {
  Vec3d axis;  ///< unit
  double one_minus_cos;

  [[nodiscard]] double solid_angle() const { return 2 * std::numbers::pi * one_minus_cos; }
};

/// A box as lights see it.
class Target {
 public:
  /// The map may turn and shear it.
  Target(const Box& box, const Affine& to_world) {
    low_ = to_world.point(box.lo);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d step;
      step[axis] = box.extent()[axis];
      edges_[axis] = to_world.vector(step);
    }
    for (int axis = 0; axis < 3; ++axis) {
      faces_[axis] = cross(edges_[(axis + 1) % 3], edges_[(axis + 2) % 3]);
    }
  }

  /// Area of the box's shadow on a plane across the direction.
  [[nodiscard]] double shadow(Vec3f d) const {
    double sum = 0;
    for (const Vec3d& face : faces_) sum += std::abs(dot(face, Vec3d(d)));
    return sum;
  }

  /// A ray along d, with its origin where it enters the box, uniform over the shadow.
  [[nodiscard]] Ray ray(Vec3f d, Rng& rng) const {
    const auto [u, v] = rng.uniform2();
    double left = double(rng.uniform()) * shadow(d);
    int axis = 0;
    while (axis < 2 && left >= std::abs(dot(faces_[axis], Vec3d(d)))) {
      left -= std::abs(dot(faces_[axis], Vec3d(d)));
      ++axis;
    }
    // The light comes in through the face whose inward normal points along it.
    const bool far = dot(faces_[axis], Vec3d(d)) * dot(faces_[axis], edges_[axis]) < 0;
    const Vec3d entry = low_ + edges_[axis] * (far ? 1 : 0) + edges_[(axis + 1) % 3] * double(u) +
                        edges_[(axis + 2) % 3] * double(v);
    return {entry, Vec3d(d)};
  }

  /// Around all directions in which the box lies from a place; all that there are, near it.
  [[nodiscard]] Cap seen_from(Vec3d place) const {
    const Vec3d diagonal = edges_[0] + edges_[1] + edges_[2], way = low_ + diagonal * 0.5 - place;
    double squared_radius = 0;  // of a sphere around the box, which need not have right angles
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        const Vec3d half = (edges_[0] + edges_[1] * y + edges_[2] * z) * 0.5;
        squared_radius = std::max(squared_radius, dot(half, half));
      }
    }
    const double squared_sine = squared_radius / dot(way, way);
    if (!(squared_sine < 1)) return {{0, 1, 0}, 2};
    return {normalize(way), squared_sine / (1 + std::sqrt(1 - squared_sine))};
  }

 private:
  Vec3d low_;
  std::array<Vec3d, 3> edges_, faces_;
};

}  // namespace pvol::detail
