// Small fields for the tests of the C API.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "pvol/embed.h"
#include "pvol/pvol.hpp"

namespace pvol::test {

/// A ball of smoke with ripples and holes, in n^3 samples, k fastest.
struct Smoke {
  std::int32_t n;
  std::vector<float> values;

  explicit Smoke(std::int32_t edge = 40, double phase = 0) : n(edge) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) values.push_back(at(i, j, k, phase));
      }
    }
  }

  [[nodiscard]] float at(int i, int j, int k, double phase) const {
    const double c = 0.5 * (n - 1);
    const double r = std::sqrt((i - c) * (i - c) + (j - c) * (j - c) + (k - c) * (k - c)) / c;
    const double ripple = 1 + 0.8 * std::sin(0.6 * i + phase) * std::sin(0.45 * j + 0.3 * k);
    return r < 0.9 ? float((0.95 - r) * ripple) : 0;
  }
  [[nodiscard]] pvol_array array() const { return api::array(values.data(), {{n, n, n}}); }
};

/// Lattice points to a world that is turned, stretched and far from the origin.
inline constexpr std::array<double, 12> kPlacement = {0.08, -0.06, 0, 100, 0.06, 0.08,
                                                      0,    -20,   0, 0,   0.12, 7};

[[nodiscard]] inline Affine placement() {
  Affine a;
  for (std::size_t row = 0; row < 3; ++row) {
    a.m[row] = {kPlacement[4 * row], kPlacement[4 * row + 1], kPlacement[4 * row + 2]};
    a.t[int(row)] = kPlacement[4 * row + 3];
  }
  return a;
}

[[nodiscard]] inline api::Volume make_smoke(const Smoke& smoke, double extinction = 3) {
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement);
  v.set_extinction(extinction).commit();
  return v;
}

/// The same by the C++ API.
[[nodiscard]] inline Volume make_same(const Smoke& smoke, double extinction = 3,
                                      LookUp look_up = LookUp::trilinear) {
  const VoxelGrid grid =
      make_grid({.values = smoke.values.data(), .size = Vec3i(smoke.n)}, placement());
  return make_volume(grid, {.extinction = extinction}, {.look_up = look_up});
}

[[nodiscard]] inline api::Vec place_of(double i, double j, double k) {
  const Vec3d p = placement().point({i, j, k});
  return {p.x, p.y, p.z};
}

/// A ray through the smoke by two places in its cells.
[[nodiscard]] inline pvol_ray ray_between(Vec3d from, Vec3d to, double t_max = api::kInfinity) {
  const Vec3d o = placement().point(from), d = placement().vector(to - from);
  return api::ray({o.x, o.y, o.z}, {d.x, d.y, d.z}, t_max);
}
[[nodiscard]] inline pvol_ray random_ray(Rng& rng, int n) {
  const auto point = [&] {
    const auto [a, b] = rng.uniform2();
    return Vec3d(double(a), double(b), double(rng.uniform())) * double(n);
  };
  const Vec3d from = point() * 3.0 - Vec3d(n), to = point();
  return ray_between(from, to);
}
[[nodiscard]] inline Ray same(const pvol_ray& r) {
  return {{r.o[0], r.o[1], r.o[2]}, {r.d[0], r.d[1], r.d[2]}};
}

/// Expects all that rays among n^3 samples ask of two volumes to be equal, to the last bit.
inline void expect_same(const api::Volume& a, const api::Volume& b, int n, const char* frame) {
  ASSERT_EQ(a.box(), b.box()) << frame;
  Rng rng(1, 2, 3);
  int collisions = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const pvol_ray ray = random_ray(rng, n);
    api::Random x(5, 6, i), y(5, 6, i);
    const auto t = a.flight(ray, x);
    ASSERT_EQ(t, b.flight(ray, y)) << frame << ", ray " << i;
    collisions += t.has_value();
    ASSERT_EQ(a.transmittance(ray, PVOL_RATIO, x), b.transmittance(ray, PVOL_RATIO, y)) << frame;
    const api::Vec lo{ray.o[0], ray.o[1], ray.o[2]}, hi{lo[0] + 2, lo[1] + 2, lo[2] + 2};
    float mine[2], theirs[2];
    ASSERT_EQ(pvol_extinction_range(a.get(), lo.data(), hi.data(), mine), 1);
    ASSERT_EQ(pvol_extinction_range(b.get(), lo.data(), hi.data(), theirs), 1);
    ASSERT_EQ(mine[0], theirs[0]) << frame;
    ASSERT_EQ(mine[1], theirs[1]) << frame;
  }
  if (a.box()) {
    EXPECT_GT(collisions, 0) << frame;
  }
}

/// The same of batches, which read bounds of their own.
inline void expect_same_batches(const api::Volume& a, const api::Volume& b, int n,
                                const char* frame) {
  Rng rng(1, 2, 4);
  std::vector<double> o, d, t(200), u(200);
  for (int i = 0; i < 200; ++i) {
    const pvol_ray ray = random_ray(rng, n);
    o.insert(o.end(), ray.o, ray.o + 3), d.insert(d.end(), ray.d, ray.d + 3);
  }
  pvol_rays rays{};
  rays.count = 200;
  rays.origins = api::vectors(o.data()), rays.directions = api::vectors(d.data());
  pvol_streams streams{};
  EXPECT_EQ(a.flights(rays, streams, {t.data(), 200}), b.flights(rays, streams, {u.data(), 200}));
  EXPECT_EQ(t, u) << frame;
}

}  // namespace pvol::test
