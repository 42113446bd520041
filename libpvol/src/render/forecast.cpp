#include "render/forecast.h"

#include <algorithm>
#include <cmath>

#include "pvol/bounds/integrals.h"
#include "pvol/bounds/walk.h"
#include "pvol/volume/extinction_source.h"
#include "render/path/camera_rays.h"

namespace pvol::detail {
namespace {

/// Optical depth of a ray through a volume by one look-up in each segment, right on average.
template <LookUp kLookUp>
[[nodiscard]] double sample_depth(const VolumeSetup& v, const Ray& world, Rng& rng) {
  const Ray ray = v.in_cells(world);
  const auto span = v.in_box(ray);
  if (!span) return 0;
  const VolumeField& f = v.volume.density;
  const auto mu = extinction_source<kLookUp>(f);
  Walk walk(f.octree, make_cursor(f.octree, ray.at(span->t0)), v.in_cells(Vec3f(world.d)));
  double depth = 0;
  while (const auto s = walk.next()) {
    const double length = s->t1 - s->t0;
    depth += double(mu(*s, walk.point(s->t0 + double(rng.uniform()) * length))) * length;
  }
  return depth;
}

/// Collisions of a camera path, from a coarse grid of camera rays: those that collide scatter about
/// as often as the cloud is thick there.
[[nodiscard]] double collisions_per_sample(const RenderPlan& plan, double albedo) {
  constexpr int kRaysAlong = 24;
  constexpr std::uint64_t kKey = 0x666f726563617374;
  const RenderOptions& o = plan.scene.options;
  const Projection projection(plan.scene.camera, o.width, o.height);
  std::vector<VolumeSetup> volumes;
  for (const Volume& v : plan.volumes) volumes.emplace_back(v, Rgb(0.0f));
  double sum = 0;
  visit_coarse_rays(projection, o, kRaysAlong, [&](const Ray& ray, int i) {
    Rng rng(kKey, 0, std::uint64_t(i));
    double depth = 0;
    for (const VolumeSetup& v : volumes) {
      depth += visit_look_up(v.volume.density.look_up,
                             [&](auto look_up) { return sample_depth<look_up>(v, ray, rng); });
    }
    double scatterings = estimate_scatterings(depth, albedo);
    if (o.max_bounces) scatterings = std::min(scatterings, double(*o.max_bounces) + 1);
    sum += -std::expm1(-depth) * scatterings;
  });
  return sum / (kRaysAlong * kRaysAlong);
}

/// Nanoseconds of a flight that ends in a collision: tentative collisions as many as the bounds
/// lead to expect, with look-ups for those that they leave open.
double flight_cost(std::span<const Volume> volumes) {
  constexpr double kSegments = 3;  // of a free path, where a walk stops by cost
  const WalkCosts costs;
  BoundIntegrals all;
  for (const Volume& v : volumes) {
    const BoundIntegrals b = integrate_bounds(v.density.octree);
    all.hi += b.hi;
    all.lo += b.lo;
  }
  if (!(all.hi > 0)) return 0;
  const double tentative = 2 * all.hi / (all.hi + all.lo);
  return kSegments * costs.segment + tentative * costs.tentative + all.open_share() * costs.lookup;
}

}  // namespace

Forecast forecast(const RenderPlan& plan) {
  const Scene& scene = plan.scene;
  const ImagePart part = image_part(scene.options);
  Forecast f;
  f.samples = double(part.width) * part.height * scene.options.samples;
  double albedo = 0;
  for (const Volume& v : plan.volumes) {
    albedo = std::max(albedo, double(largest_albedo(v.medium)));
  }
  f.collisions = f.samples * collisions_per_sample(plan, albedo);
  // Pictures of skies are sampled as lights are.
  const bool picture = std::holds_alternative<ImageSky>(scene.environment);
  const double lights = double(scene.lights.size()) + (picture ? 1 : 0);
  constexpr double kSample = 200, kScattering = 100;  // ns besides flights
  f.cpu_seconds = 1e-9 * (f.samples * kSample +
                          f.collisions * (kScattering + (1 + lights) * flight_cost(plan.volumes)));
  return f;
}

}  // namespace pvol::detail
