// What lights bring to a place, to a surface or to a flight, about, many at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol::detail {

/// Lights, as if they shone evenly from places, or groups of them as one, in groups of kGroup.
struct LightGroups {
  static constexpr std::size_t kGroup = 16;  ///< floats in the widest register
  static constexpr float kLeast = 1e-36f;    ///< of weights that are not 0
  static constexpr float kMost = 1e30f;

  std::array<std::vector<double>, 3> place;  ///< its middle
  std::vector<float> power;                  ///< 0 where a group has no more
  std::vector<float> radius;                 ///< of the ball that it lies in; 0 of a point

  [[nodiscard]] std::size_t count_groups() const { return power.size() / kGroup; }
  /// Appends a group without any light.
  void add_group();
};

/// Where lights are weighed: at a place of a volume, ...
struct AtPlace {
  Vec3d place;
};
/// ... of a surface with this normal, of length 1, ...
struct OnPlane {
  Vec3d place;
  Vec3d normal;
};
/// ... or all along a flight in this direction, of length 1.
struct AlongFlight {
  Vec3d from;
  Vec3d direction;
  double length;
};

/// Of the lights of a group, as if nothing were in the way: power / distance^2, times the cosine on
/// a plane; along a flight the integral of that (THEORY.md, T5.19, T5.25). Above 0 for each that
/// has power. Returns which of them are so near beside their radii that this tells little, as bits.
struct LightKernel {
  std::uint32_t (*at_place)(const LightGroups&, std::size_t group, const AtPlace&, float* to);
  std::uint32_t (*on_plane)(const LightGroups&, std::size_t group, const OnPlane&, float* to);
  std::uint32_t (*along_flight)(const LightGroups&, std::size_t group, const AlongFlight&,
                                float* to);
  /// Multiplies the weights of a group by factors[numbers[k]], which are finite.
  void (*multiply)(const float* factors, const std::uint32_t* numbers, float* weights);

  std::uint32_t weigh(const LightGroups& g, std::size_t group, const AtPlace& from,
                      float* to) const {
    return at_place(g, group, from, to);
  }
  std::uint32_t weigh(const LightGroups& g, std::size_t group, const OnPlane& from,
                      float* to) const {
    return on_plane(g, group, from, to);
  }
  std::uint32_t weigh(const LightGroups& g, std::size_t group, const AlongFlight& from,
                      float* to) const {
    return along_flight(g, group, from, to);
  }
};

/// Of all instructions that the processor has and there is a kernel for, the widest first, plain
/// ones last: all give the same bits.
[[nodiscard]] std::vector<LightKernel> light_kernels();

/// The first of them.
[[nodiscard]] const LightKernel& light_kernel();

}  // namespace pvol::detail
