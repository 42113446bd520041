// Rays of a batch as kernels read them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "pvol/math/box.h"
#include "pvol/math/rng.h"
#include "pvol/volume/batch.h"
#include "pvol/volume/volume.h"
#include "volume/unit_direction.h"

namespace pvol::detail {

[[nodiscard]] inline double number_at(const void* at, bool is_double) {
  if (is_double) {
    double v;
    std::memcpy(&v, at, sizeof v);
    return v;
  }
  float v;
  std::memcpy(&v, at, sizeof v);
  return double(v);
}

[[nodiscard]] inline double number_at(const NumberArray& a, std::size_t i) {
  if (a.data == nullptr) return std::numeric_limits<double>::infinity();
  return number_at(static_cast<const char*>(a.data) + std::ptrdiff_t(i) * a.stride, a.doubles);
}

[[nodiscard]] inline Vec3d vector_at(const VectorArray& a, std::size_t i) {
  const char* const p = static_cast<const char*>(a.data) + std::ptrdiff_t(i) * a.stride;
  return {number_at(p, a.doubles), number_at(p + a.component_stride, a.doubles),
          number_at(p + 2 * a.component_stride, a.doubles)};
}

struct BatchRay {
  Ray world;  ///< its direction is of a length whose square is a normal number
  double t_max;
};

/// Ray i, or nothing where it is bad, but for one too far away. Directions whose squares leave the
/// range of doubles are scaled.
[[nodiscard]] inline std::optional<BatchRay> read_ray(const RayBatch& rays, std::size_t i) {
  BatchRay r{{vector_at(rays.origins, i), vector_at(rays.directions, i)}, number_at(rays.t_max, i)};
  r.world.d = in_range(r.world.d);
  if (r.world.d == Vec3d{} || !is_finite(r.world.o) || std::isnan(r.t_max)) return std::nullopt;
  return r;
}

[[nodiscard]] inline Rng numbers_of(const BatchNumbers& n, std::size_t i) {
  return {n.seed, n.streams != nullptr ? n.streams[i] : n.first + i, n.sample};
}

}  // namespace pvol::detail
