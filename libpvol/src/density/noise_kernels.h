// Sums of octaves at many points at once.
#pragma once

#include <cstddef>
#include <vector>

#include "pvol/density/noise.h"

namespace pvol::detail {

/// Points in arrays of one length, which kernels read and write in whole registers.
struct NoisePoints {
  static constexpr std::size_t kRegister = 8;  ///< doubles in the widest
  std::vector<double> x, y, z;
  std::vector<double> noise;
  std::size_t n = 0;

  void add(Vec3d p) {
    if (n == x.size()) {
      for (std::vector<double>* all : {&x, &y, &z, &noise}) all->resize(2 * n + kRegister);
    }
    x[n] = p.x, y[n] = p.y, z[n] = p.z;
    ++n;
  }
};

/// Finds fbm() at all points, to the last bit.
using FbmKernel = void (*)(const Fbm& fbm, NoisePoints& points);

/// Of all instructions that the processor has and there is a kernel for, the widest first.
[[nodiscard]] std::vector<FbmKernel> fbm_kernels();

/// By the first of these, or point by point.
void find_fbm(const Fbm& fbm, NoisePoints& points);

}  // namespace pvol::detail
