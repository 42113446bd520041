// Many points of a shell's frame, one array for each coordinate, for loops over vector registers.
#pragma once

#include <cstddef>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol::detail {

struct Points {
  std::vector<float> x, y, z;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] Vec3f operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  void add(Vec3f p) {
    x.push_back(p.x);
    y.push_back(p.y);
    z.push_back(p.z);
  }
};

}  // namespace pvol::detail
