// Clouds as other renderers hand them over, placed in the world in every way, for tests of the
// calls that those renderers make.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "pvol/trackers.h"
#include "support/effort.h"
#include "support/oracle.h"

namespace pvol::test {

inline const std::uint64_t kPlacedSeed = proof::seeded(20240607);
inline constexpr double kFar = std::numeric_limits<double>::infinity();
inline constexpr auto kTrilinear = LookUp::trilinear, kNearest = LookUp::nearest;

/// Cell edges of a map, about.
inline double cell_length(const Affine& to_world) {
  return std::cbrt(std::abs(determinant(to_world)));
}

/// A placement of a field in the world.
struct Placement {
  std::string name;
  Affine to_world;
};

inline const std::vector<Placement>& placements() {
  Affine turned;
  turned.m = {Vec3d{0.36, 0.48, -0.8}, Vec3d{-0.8, 0.6, 0}, Vec3d{0.48, 0.64, 0.6}};
  turned.t = {3, -70, 11};
  Affine sheared;
  sheared.m = {Vec3d{1, 0.7, -0.2}, Vec3d{0, 0.5, 0.3}, Vec3d{0.1, 0, 2}};
  Affine mirrored = scaling({-1, 1, 3});
  static const std::vector<Placement> all{{"identity", {}},
                                          {"turned", turned},
                                          {"sheared", sheared},
                                          {"mirrored", mirrored},
                                          {"small", scaling(Vec3d(1e-3)) * turned},
                                          {"large", scaling(Vec3d(1e3)) * sheared}};
  return all;
}

/// A field as an embedding renderer hands it over, with its optical depth along rays of the world.
struct PlacedCloud {
  const Field& field;
  Affine to_world;
  double extinction;
  VolumeOptions options;
  Volume volume;

  PlacedCloud(const Field& f, const Affine& placement, double mu, const VolumeOptions& o = {})
      : field(f), to_world(placement), extinction(mu), options(o) {
    const VoxelGrid grid =
        make_grid({.values = f.samples.data(), .size = f.size, .origin = f.origin}, placement);
    volume = make_volume(grid, {.extinction = mu}, o);
  }

  [[nodiscard]] RayOracle oracle(const Ray& ray, double t_max = kFar) const {
    const Affine to_index = inverse(to_world);
    const Vec3d unit = normalize(ray.d);
    return {
        field, options.look_up, {to_index.point(ray.o), to_index.vector(unit)}, extinction, t_max};
  }

  /// A place of the world near density, or anywhere about the cloud.
  [[nodiscard]] Vec3d place_inside(Rng& rng) const {
    return to_world.point(random_point_near_density(field, rng));
  }
  [[nodiscard]] Vec3d place_outside(Rng& rng) const {
    const Vec3d size(field.size);
    const Vec3d centre = Vec3d(field.origin) + size * 0.5;
    return to_world.point(centre + random_direction(rng) * (2 * length(size)));
  }

  [[nodiscard]] static Vec3d random_direction(Rng& rng) {
    for (;;) {
      const auto [a, b] = rng.uniform2();
      const Vec3d d = Vec3d(double(a), double(b), double(rng.uniform())) * 2.0 - Vec3d(1);
      if (length(d) > 0.1 && length(d) < 1) return normalize(d);
    }
  }

  /// A ray of each kind: from outside through the density, from inside, along an axis of the
  /// lattice, and to a t_max inside from inside and from outside.
  struct Aimed {
    Ray ray;
    double t_max;
  };
  [[nodiscard]] Aimed aim(int kind, Rng& rng) const {
    const Vec3d inside = place_inside(rng);
    const Vec3d outside = place_outside(rng);
    switch (kind) {
      case 0:
        return {{outside, normalize(inside - outside)}, kFar};
      case 1:
        return {{inside, random_direction(rng)}, kFar};
      case 2: {
        Vec3d axis;
        axis[int(rng.block().lo % 3)] = rng.block().lo & 1 ? 1 : -1;
        const Vec3d d = normalize(to_world.vector(axis));
        return {{inside - d * (rng.uniform() < 0.5f ? 300 * cell_length(to_world) : 0), d}, kFar};
      }
      default:
        const Vec3d from = kind == 3 ? place_inside(rng) : outside;
        return {{from, normalize(inside - from)}, length(inside - from)};
    }
  }
};
inline constexpr int kKinds = 5;

/// Positions are floats within cells: their error along a ray is some 1e-6 cells, in mu_t and thus
/// in the optical depth of the cells where they count.
inline constexpr double kRounding = 2e-5;

/// Fields that take few bricks and differ in everything else.
inline const std::vector<std::string> kNames{
    "linear", "gaussian", "checkerboard", "contrast", "one_voxel_on_a_border", "sparse", "far"};

/// f(cloud, name) for each of these fields in each placement; its largest depth per voxel is 1/4.
inline void for_clouds(const std::function<void(const PlacedCloud&, const std::string&)>& f,
                       const VolumeOptions& options = {}) {
  for (const std::string& name : kNames) {
    for (const Placement& p : placements()) {
      const PlacedCloud cloud(field(name), p.to_world, 0.25 / cell_length(p.to_world), options);
      f(cloud, name + ", " + p.name);
    }
  }
}

}  // namespace pvol::test
