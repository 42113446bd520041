// The medium of other renderers: a NanoVDB grid, and a coarse grid of majorants that rays cross
// cell by cell (Amanatides and Woo 1987), as in pbrt-v4, in float. What it costs is what pvol is
// measured against, so it is written as well as we know how.
#pragma once

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "nano_grid.h"
#include "pvol/math/box.h"
#include "pvol/math/rng.h"
#include "pvol/track/transmittance.h"

namespace pvol::bench {

/// kEdge^3 majorants of mu_t over the box of the support.
struct MajorantGrid {
  static constexpr int kEdge = 64;
  Vec3f low, cells_per_unit;                                                ///< in index space
  std::vector<float> majorant = std::vector<float>(kEdge * kEdge * kEdge);  ///< z fastest
};

[[nodiscard]] inline MajorantGrid make_majorants(const VoxelGrid& grid, float extinction) {
  Vec3i low(std::numeric_limits<int>::max()), high(std::numeric_limits<int>::min());
  for_samples(grid, [&](Vec3i at, float) { low = min(low, at), high = max(high, at); });
  MajorantGrid m;
  m.low = Vec3f(low - Vec3i(1));
  for (int axis = 0; axis < 3; ++axis) {
    m.cells_per_unit[axis] = float(m.kEdge) / float(high[axis] - low[axis] + 2);
  }
  const auto cell = [&](Vec3i at, int axis) {
    const float x = (float(at[axis]) - m.low[axis]) * m.cells_per_unit[axis];
    return std::clamp(int(std::floor(x)), 0, m.kEdge - 1);
  };
  // Trilinear interpolation carries a sample one cell of the lattice to either side.
  for_samples(grid, [&](Vec3i at, float v) {
    const Vec3i from = at - Vec3i(1), to = at + Vec3i(1);
    for (int x = cell(from, 0); x <= cell(to, 0); ++x) {
      for (int y = cell(from, 1); y <= cell(to, 1); ++y) {
        for (int z = cell(from, 2); z <= cell(to, 2); ++z) {
          float& bound = m.majorant[std::size_t((x * m.kEdge + y) * m.kEdge + z)];
          bound = std::max(bound, extinction * v);
        }
      }
    }
  });
  return m;
}

struct NanoMedium {
  NanoHandle handle;
  MajorantGrid majorants;
  float extinction;
  Vec3f to_index[3], index_origin;  ///< rows of world to index, and what is added

  [[nodiscard]] Vec3f vector(Vec3f v) const {
    return {dot(to_index[0], v), dot(to_index[1], v), dot(to_index[2], v)};
  }
  [[nodiscard]] Vec3f point(Vec3f p) const { return vector(p) + index_origin; }
  [[nodiscard]] const nanovdb::FloatGrid& grid() const { return *handle.grid<float>(); }
  [[nodiscard]] std::size_t bytes() const {
    return handle.size() + majorants.majorant.size() * sizeof(float);
  }
};

[[nodiscard]] inline NanoMedium make_nano_medium(const VoxelGrid& grid, float extinction) {
  const Affine to_index = inverse(grid.index_to_world);
  NanoMedium m{make_nano(grid), make_majorants(grid, extinction), extinction, {}, {}};
  for (std::size_t row = 0; row < 3; ++row) m.to_index[row] = Vec3f(to_index.m[row]);
  m.index_origin = Vec3f(to_index.t);
  return m;
}

/// A ray in index space.
struct IndexRay {
  Vec3f o, d;
};

/// Visits the tentative collisions of a ray until visit(t, majorant, u) returns true: then the
/// result is true.
template <class Count, class Visit>
[[nodiscard, gnu::always_inline]] inline bool visit_cells(const MajorantGrid& m,
                                                          const IndexRay& ray, Rng& rng,
                                                          Count& count, const Visit& visit) {
  constexpr int kEdge = MajorantGrid::kEdge;
  constexpr float kTiny = std::numeric_limits<float>::min();
  const Vec3f o = (ray.o - m.low) * m.cells_per_unit, d = ray.d * m.cells_per_unit;
  float inv[3], next[3], t = 0, end = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    inv[axis] = 1 / (std::abs(d[axis]) < kTiny ? std::copysign(kTiny, d[axis]) : d[axis]);
    const float a = -o[axis] * inv[axis], b = (float(kEdge) - o[axis]) * inv[axis];
    t = std::max(t, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  if (!(t < end)) return false;

  constexpr int kStride[3] = {kEdge * kEdge, kEdge, 1};
  int cell = 0, stride[3], left[3];  // cells to go before the ray leaves the grid
  for (int axis = 0; axis < 3; ++axis) {
    const int at = std::clamp(int(o[axis] + d[axis] * t), 0, kEdge - 1);
    const bool up = inv[axis] > 0;
    cell += at * kStride[axis];
    stride[axis] = up ? kStride[axis] : -kStride[axis];
    left[axis] = up ? kEdge - at : at + 1;
    next[axis] = (float(up ? at + 1 : at) - o[axis]) * inv[axis];
    inv[axis] = std::abs(inv[axis]);
  }

  Rng::Tentative ahead = rng.tentative();
  for (;;) {
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    const float t1 = std::min(next[axis], end);
    count.segment();
    if (const float majorant = m.majorant[std::size_t(cell)]; majorant > 0) {
      float rest;
      while (ahead.depth < (rest = majorant * (t1 - t))) {
        t += ahead.depth / majorant;
        if (visit(t, majorant, ahead.u)) return true;
        ahead = rng.tentative();
      }
      ahead.depth -= rest;
    }
    if (--left[axis] == 0) return false;
    t = t1;
    cell += stride[axis];
    next[axis] += inv[axis];
  }
}

using NanoTree = nanovdb::FloatGrid::TreeType;
using NanoAccessor = nanovdb::FloatGrid::AccessorType;

/// What one path needs: the medium and what looks its grid up, which is the tree itself or an
/// accessor that remembers the last leaf. Shadow rays are analog or by ratio tracking.
template <class Access, bool kAnalog>
struct NanoPath {
  const NanoMedium& medium;
  Access access;

  [[nodiscard]] float extinction(Vec3f at) const {
    const nanovdb::SampleFromVoxels<std::remove_cvref_t<Access>, 1, false> sampler(access);
    return medium.extinction * sampler(nanovdb::Vec3f(at.x, at.y, at.z));
  }
  [[nodiscard]] IndexRay in_index(const Ray& ray) const {
    return {medium.point(Vec3f(ray.o)), medium.vector(Vec3f(ray.d))};
  }

  template <class Count>
  [[nodiscard]] double flight(const Ray& ray, Rng& rng, Count& count) const {
    const IndexRay r = in_index(ray);
    double hit = std::numeric_limits<double>::infinity();
    (void)visit_cells(medium.majorants, r, rng, count, [&](float t, float majorant, float u) {
      count.lookup();
      if (!(u * majorant < extinction(r.o + r.d * t))) return false;
      hit = double(t);
      return true;
    });
    return hit;
  }

  /// Of the whole ray, with the roulette that pvol has.
  template <class Count>
  [[nodiscard]] float transmittance(const Ray& ray, Rng& rng, Count& count) const {
    if constexpr (kAnalog) return std::isfinite(flight(ray, rng, count)) ? 0.0f : 1.0f;
    const IndexRay r = in_index(ray);
    float weight = 1;
    const auto ends = [&](float t, float majorant, float u) {
      count.lookup();
      weight *= std::max(0.0f, 1 - extinction(r.o + r.d * t) / majorant);
      return !detail::survives(weight, u);
    };
    return visit_cells(medium.majorants, r, rng, count, ends) ? 0.0f : weight;
  }
};

}  // namespace pvol::bench
