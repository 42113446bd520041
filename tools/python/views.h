// Numbers of an array in memory that somebody else keeps, whatever its strides.
#pragma once

#include <cstddef>
#include <cstring>

#include "pvol/math/box.h"

namespace pvol::python {

/// Doubles `step` bytes apart; 0 for one that counts for all.
struct Numbers {
  const char* data = nullptr;
  std::ptrdiff_t step = 0;

  [[nodiscard]] double operator[](std::size_t i) const { return read(data + step * long(i)); }
  [[nodiscard]] static double read(const char* at) {
    double value;
    std::memcpy(&value, at, sizeof value);  // arrays within records need not be aligned
    return value;
  }
};

/// Vectors `step` bytes apart, whose components are `axis` bytes apart.
struct Vectors {
  const char* data = nullptr;
  std::ptrdiff_t step = 0, axis = sizeof(double);
  std::size_t count = 0;

  [[nodiscard]] Vec3d operator[](std::size_t i) const {
    const char* v = data + step * long(i);
    return {Numbers::read(v), Numbers::read(v + axis), Numbers::read(v + 2 * axis)};
  }
};

/// Rays and how far each goes, in world units.
struct RayViews {
  Vectors origins, directions;
  Numbers t_max;

  [[nodiscard]] std::size_t count() const { return origins.count; }
  [[nodiscard]] Ray operator[](std::size_t i) const { return {origins[i], directions[i]}; }
};

}  // namespace pvol::python
