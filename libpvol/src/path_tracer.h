// One camera path: free flights, next-event estimation, scattering.
#pragma once

#include <numbers>

#include "pvol/medium/phase.h"
#include "pvol/render/film.h"
#include "pvol/render/lights.h"
#include "pvol/render/volume.h"
#include "pvol/track/transmittance.h"

namespace pvol::detail {

/// Perspective projection with its constants.
struct Projection {
  Vec3d origin, corner, right,
      down;  // the point at image (0, 0) and steps of one pixel, at distance 1

  Projection(const Camera& camera, int width, int height) : origin(camera.position) {
    const Vec3d forward = normalize(camera.target - camera.position);
    const Vec3d x = normalize(cross(forward, camera.up)), y = cross(forward, x);
    const double pixel = 2 * std::tan(camera.fov / 360 * std::numbers::pi) / height;
    right = x * pixel;
    down = y * pixel;
    corner = forward - right * (width / 2.0) - down * (height / 2.0);
  }

  [[nodiscard]] Vec3d direction(double x, double y) const {
    return normalize(corner + right * x + down * y);
  }
};

/// Exact extinction for a tracker's look-ups.
template <Interpolation kInterpolation>
struct ExactExtinction {
  const Volume& volume;
  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return volume.extinction * density<kInterpolation>(volume.field, volume.octree, s.leaf, p);
  }
};

/// What all paths of an image share.
struct PathSetup {
  const Volume& volume;
  Float4 cells_x, cells_y,
      cells_z;  // change of the position in cells per unit along each world axis
  Projection projection;
  SkyLight sky;
  std::vector<SunLight> suns;
  HenyeyGreenstein phase;
  Rgb albedo;
  bool background;
  std::uint32_t max_bounces;
  std::uint64_t seed;
  int width;

  PathSetup(const Volume& v, const Scene& scene)
      : volume(v),
        cells_x(lanes(Vec3f(v.world_to_cells.vector({1, 0, 0})))),
        cells_y(lanes(Vec3f(v.world_to_cells.vector({0, 1, 0})))),
        cells_z(lanes(Vec3f(v.world_to_cells.vector({0, 0, 1})))),
        projection(scene.camera, scene.options.width, scene.options.height),
        sky(scene.environment),
        suns(scene.suns.begin(), scene.suns.end()),
        phase(scene.medium.g),
        albedo(scene.medium.albedo),
        background(scene.options.background),
        max_bounces(scene.options.max_bounces.value_or(~0u)),
        seed(scene.options.seed),
        width(scene.options.width) {}
};

/// Weight of a sample of one technique against another (Veach 1997, balance heuristic).
[[nodiscard]] inline float balance(float pdf, float other) { return pdf / (pdf + other); }

/// Paths of a throughput below this are continued with probability throughput / threshold.
inline constexpr float kPathRoulette = 1.0f / 16;

/// Traces paths for one choice of interpolation, tracker and estimator. Each is chosen once a
/// scene, not once a collision.
template <Interpolation kInterpolation, Tracker kTracker, Transmittance kTransmittance, class Count>
class PathTracer {
 public:
  explicit PathTracer(const PathSetup& setup) : s_(setup), extinction_{setup.volume} {}

  struct Result {
    Rgb radiance{0.0f};
    bool scattered = false;
  };

  Result trace(int x, int y, std::uint32_t sample) {
    Rng rng(s_.seed, std::uint64_t(y) * std::uint64_t(s_.width) + std::uint64_t(x), sample);
    const auto [jitter_x, jitter_y] = rng.uniform2();
    const Ray ray{s_.projection.origin,
                  s_.projection.direction(x + double(jitter_x), y + double(jitter_y))};
    const Affine& to_cells = s_.volume.world_to_cells;
    const Ray in_cells{to_cells.point(ray.o), to_cells.vector(ray.d)};
    const auto span = s_.volume.octree.empty() ? std::nullopt
                                               : intersect(s_.volume.octree.support(), in_cells, 0,
                                                           std::numeric_limits<double>::infinity());
    direction_ = Vec3f(ray.d);
    if (!span) return {s_.background ? seen_light() : Rgb(0.0f), false};
    return walk(make_cursor(s_.volume.octree, in_cells.at(span->t0)), rng);
  }

  Count path_count, shadow_count;
  std::uint64_t collisions = 0, shadow_rays = 0;

 private:
  const PathSetup& s_;
  ExactExtinction<kInterpolation> extinction_;
  Vec3f direction_;  // of the flight, in the world
  Vec3f from_;       // before the last scattering

  [[nodiscard]] Float4 in_cells(Vec3f direction) const {
    return s_.cells_x * splat(direction.x) + s_.cells_y * splat(direction.y) +
           s_.cells_z * splat(direction.z);
  }

  Result walk(Cursor cursor, Rng& rng) {
    Result r;
    Rgb throughput(1.0f);
    for (std::uint32_t bounces = 0;; ++bounces) {
      Walk flight(s_.volume.octree, cursor, in_cells(direction_));
      const auto t = free_flight<kTracker>(flight, extinction_, rng, path_count);
      if (!t) {
        if (bounces > 0)
          r.radiance += throughput * scattered_light();
        else if (s_.background)
          r.radiance += seen_light();
        return r;
      }
      r.scattered = true;
      ++collisions;
      if (bounces == s_.max_bounces) return r;
      cursor = flight.stop_at(flight.point(*t));
      throughput *= s_.albedo;
      const float most = max_component(throughput);
      if (most < kPathRoulette) {
        if (!(rng.uniform() * kPathRoulette < most)) return r;
        throughput *= kPathRoulette / most;
      }
      r.radiance += throughput * light_at(cursor, rng);
      from_ = direction_;
      direction_ = sample_phase(s_.phase, from_, rng);
    }
  }

  /// Light in the direction of a camera ray that met nothing.
  [[nodiscard]] Rgb seen_light() const {
    Rgb sum = s_.sky.radiance(direction_);
    for (const SunLight& sun : s_.suns) {
      if (sun.hit(direction_)) sum += sun.radiance;
    }
    return sum;
  }

  /// Light in the direction of a scattered ray that left the cloud, weighted against `light_at`.
  [[nodiscard]] Rgb scattered_light() const {
    Rgb sum = s_.sky.radiance(direction_);
    if (s_.sky.sampled()) sum *= balance(phase_pdf(), s_.sky.pdf(direction_));
    for (const SunLight& sun : s_.suns) {
      if (sun.hit(direction_)) sum += sun.radiance * balance(phase_pdf(), sun.pdf);
    }
    return sum;
  }

  [[nodiscard]] float phase_pdf() const { return pdf_phase(s_.phase, from_, direction_); }

  /// Next-event estimation: in-scattered light of every sun and of a sampled sky at the cursor.
  [[nodiscard]] Rgb light_at(const Cursor& cursor, Rng& rng) {
    Rgb sum(0.0f);
    for (const SunLight& sun : s_.suns) {
      const LightSample l = sun.sample(rng);
      const float p = pdf_phase(s_.phase, direction_, l.direction);
      const float weight = sun.delta() ? 1 : balance(l.pdf, p);
      sum += l.radiance * (weight * p / l.pdf * passes(cursor, l.direction, rng));
    }
    if (s_.sky.sampled()) {
      const LightSample l = s_.sky.sample(rng);
      const float p = pdf_phase(s_.phase, direction_, l.direction);
      sum += l.radiance * (p / (l.pdf + p) * passes(cursor, l.direction, rng));
    }
    return sum;
  }

  [[nodiscard]] float passes(const Cursor& cursor, Vec3f direction, Rng& rng) {
    ++shadow_rays;
    Walk shadow(s_.volume.octree, cursor, in_cells(direction));
    return transmittance<kTransmittance, kTracker>(shadow, extinction_, rng, shadow_count);
  }
};

}  // namespace pvol::detail
