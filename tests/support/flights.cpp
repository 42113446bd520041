#include "support/flights.h"

#include <cmath>

namespace pvol::test {
namespace {

/// A ray of this kind in index space, through or from a random point near density.
Ray random_ray(const Field& field, const Box& support, int kind, Rng& rng) {
  const Vec3d p = random_point_near_density(field, rng);
  if (kind == 1) {
    const int axis = int(rng.block().lo % 3);
    const bool up = rng.uniform() < 0.5f;
    Ray ray{p, Vec3d(0.0)};
    ray.o[axis] = up ? support.lo[axis] : support.hi[axis];
    ray.d[axis] = up ? 1 : -1;
    return ray;
  }
  const auto component = [&] { return 2 * double(rng.uniform()) - 1; };
  const Vec3d d = normalize(Vec3d{component(), component(), component()});
  return kind == 0 ? Ray{p - d * 300.0, d} : Ray{p, d};
}

/// The ray as a walk has it, in index space, scaled.
Ray of_walk(const Volume& volume, const Cursor& cursor, Float4 direction) {
  const Vec3d at = Vec3d(vec3(cursor.at.cell)) + Vec3d(vec3(cursor.at.frac));
  return {at + Vec3d(volume.density.octree.origin), Vec3d(vec3(direction))};
}

}  // namespace

Aim aim(const Field& field, const Volume& volume, LookUp look_up, int kind, double depth) {
  const Vec3d origin(volume.density.octree.origin);
  const Box support = volume.density.octree.support();
  const double largest = double(volume.density.scale) * double(field.largest);
  Rng rng(kSeed, 1, std::uint64_t(kind));
  for (;;) {
    const Ray ray = random_ray(field, {support.lo + origin, support.hi + origin}, kind, rng);
    const auto span = intersect(support, {ray.o - origin, ray.d}, 0, 1e9);
    if (!span) continue;
    const Cursor cursor = make_cursor(volume.density.octree, ray.at(span->t0) - origin);
    Float4 direction = widen(Vec3f(ray.d));
    const auto oracle = [&] {
      return RayOracle(field, look_up, of_walk(volume, cursor, direction),
                       double(volume.density.scale));
    };
    const double in_cells = oracle().optical_depth();
    constexpr double kEnoughCells = 0.25;  // of the largest density; else the ray misses the point
    if (in_cells < kEnoughCells * largest) continue;
    if (depth > 0) direction = direction * splat(float(in_cells / depth));
    return {cursor, direction, oracle()};
  }
}

const std::vector<Choice>& choices() {
  static const std::vector<Choice> all = [] {
    std::vector<Choice> c{{"delta_global", Tracker::delta_global, std::nullopt}};
    for (const int depth : {-1, 0, 2, 16}) {
      const bool by_cost = depth < 0;
      const std::string at = by_cost ? " by cost" : " at depth " + std::to_string(depth);
      const auto cut = by_cost ? std::nullopt : std::optional<int>(depth);
      c.push_back({"delta" + at, Tracker::delta, cut});
      c.push_back({"decomposition" + at, Tracker::decomposition, cut});
    }
    return c;
  }();
  return all;
}

}  // namespace pvol::test
