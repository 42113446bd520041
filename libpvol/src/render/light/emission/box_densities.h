// Boxes as a place sees them, and how long a line is in each, many at once.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol::detail {

/// Boxes with weights, in arrays that are read in whole registers.
struct SeenBoxes {
  static constexpr std::size_t kRegister = 16;  ///< floats in the widest

  /// Their number is a multiple of kRegister: those that fill it up have no power.
  std::array<std::vector<float>, 3> lo, hi, centre;
  std::vector<float> power, squared_radius, inverse_volume;

  [[nodiscard]] std::size_t size() const { return power.size(); }
  void add(Vec3f low, Vec3f high, float its_power);
  void fill_register();  ///< after the last
};

/// A line, by length from where it is nearest to the boxes' origin.
struct BoxLine {
  Vec3f nearest;
  Vec3f direction;   ///< of length 1
  float before = 0;  ///< length from the line's begin, which is behind it or there
};

/// Sums over boxes as a place sees them.
struct BoxDensities {
  float weights = 0;
  /// Of weights times the integral of t^2 along the line in the box over its volume, t the length
  /// from the line's begin.
  float along_line = 0;
};

/// A place weighs a box by its power over the squared distance, no nearer than its radius.
struct BoxKernel {
  /// To as many numbers as there are boxes.
  void (*find_weights)(const SeenBoxes& boxes, Vec3f place, float* to);
  BoxDensities (*find_densities)(const SeenBoxes& boxes, Vec3f place, const BoxLine& line);
};

/// Of all instructions that the processor has and there is a kernel for, the widest first, plain
/// ones last: all give the same bits.
[[nodiscard]] std::vector<BoxKernel> box_kernels();

/// The first of them.
[[nodiscard]] const BoxKernel& box_kernel();

}  // namespace pvol::detail
