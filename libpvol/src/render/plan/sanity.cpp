#include "render/plan/sanity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/digits.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/render/daylight.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "render/path/path_setup.h"
#include "volume/cell_look_up.h"

namespace pvol::detail {
namespace {

constexpr double kThinnest = 0.05, kThickest = 2000;  // of clouds, in mean free paths
constexpr double kUsual = 40;                         // what the tools choose, about
constexpr double kFaintest = 0.002;                   // share of camera rays that collide

[[nodiscard]] std::string named(const Volume& v, const std::string& text) {
  return v.name.empty() ? text : v.name + ": " + text;
}

[[nodiscard]] double thickness(const Volume& v) {
  return choose_transmittance(std::span(&v, 1)).thickness;
}

/// "medium.extinction = 0.83 would make it about 40 thick"
[[nodiscard]] std::string usual_extinction(const Volume& v) {
  return "medium.extinction = " + digits(v.medium.extinction * kUsual / thickness(v), 2) +
         " would make it about " + digits(kUsual) + " mean free paths thick";
}

[[nodiscard]] std::string growing_weights(double excess, double thickness, double growth,
                                          double most) {
  return "weights would grow without bound: majorants are up to " + digits(excess) +
         " times too low in a cloud of optical thickness up to " + digits(thickness) +
         ", so the variance grows by exp(" + digits(growth) + "), expected at most exp(" +
         digits(most) +
         "). Fit the cloud again, raise --majorant-scale, or render anyway with --force.";
}

[[nodiscard]] std::string null_collisions(const Volume& v, double count) {
  return "a ray would meet about " + digits(count) +
         " null collisions in one segment, expected at most " + digits(kMostNullCollisions) + ". " +
         usual_extinction(v) +
         "; or leave --depth at auto and --tracker at decomposition, or render anyway with "
         "--force.";
}

[[nodiscard]] std::string scatterings(const Volume& v, double count) {
  return "a path would scatter about " + digits(count) + " times, expected at most " +
         digits(kMostScatterings) + ": the cloud is about " + digits(thickness(v)) +
         " mean free paths thick and has albedo " + digits(double(largest_albedo(v))) + ". " +
         usual_extinction(v) +
         "; or limit paths with --max-bounces N, or render anyway with --force.";
}

[[nodiscard]] std::string point(const Vec3d& p) {
  return '(' + digits(p.x) + ", " + digits(p.y) + ", " + digits(p.z) + ')';
}

[[nodiscard]] std::string unseen(const RenderPlan& plan, int rays) {
  const Box all = world_box(plan.volumes);
  const Camera& c = plan.scene.camera;
  return "none of " + std::to_string(rays) + " rays through the picture hits a volume: from " +
         point(c.position) + " the camera looks towards " + point(c.target) +
         ", but the density lies between " + point(all.lo) + " and " + point(all.hi) +
         (plan.surfaces ? ", or surfaces hide it" : "");
}

/// Whether some leaf is as thick as a mean free path: a cloud that is thin all the same is lost in
/// its box.
[[nodiscard]] bool is_dense_somewhere(const Volume& v) {
  float most = 0;
  for (const Octree::Entry& e : v.density.octree.entries) most = std::max(most, e.hi);
  const double cell = std::cbrt(std::abs(determinant(inverse(v.density.world_to_cells))));
  return double(most) / v.density.majorant_scale * cell * kLeafEdge >= 1;
}

/// What is wrong with a volume's thickness, if anything.
[[nodiscard]] std::string warn_of_thickness(const Volume& v) {
  if (v.density.octree.empty()) {
    return v.fire != nullptr ? "" : named(v, "the density is 0 everywhere");
  }
  if (v.medium.extinction == 0)
    return named(v, "medium.extinction is 0, so the volume is invisible");
  const double t = thickness(v);
  if (t <= kThickest && (t >= kThinnest || is_dense_somewhere(v))) return {};
  return named(v, "the cloud is about " + digits(t) + " mean free paths thick, expected " +
                      digits(kThinnest) + " to " + digits(kThickest) + ". Does its extinction of " +
                      digits(v.medium.extinction) + " have the right unit? " + usual_extinction(v));
}

/// Warnings about a volume's motion.
void warn_of_motion(const Volume& v, std::vector<std::string>& all) {
  if (motion_of(v) == nullptr) return;
  const Motion& m = *motion_of(v);
  if (m.longest > m.still_extent) {
    all.push_back(named(v, "while the shutter is open, the medium moves by up to " +
                               digits(m.longest) + " voxels, more than the cloud's " +
                               digits(m.still_extent) +
                               ". Check for single velocities far above the others, and check the "
                               "unit of their scale and the camera's fps"));
  }
  if (v.fire != nullptr && v.fire->field.motion == nullptr) {
    all.push_back(named(v, "its fire stands still while its density moves"));
  }
}

/// Share of the camera's rays through boxes that collide.
[[nodiscard]] double opacity(const CameraProbe& probe) {
  double sum = 0;
  for (const double depth : probe.depths) sum += -std::expm1(-depth);
  return sum / double(probe.depths.size());
}

}  // namespace

void refuse_endless_flights(const Volume& v, const VolumeFacts* facts, const RenderOptions& o) {
  // Second moments of weights grow by exp(4 (k - 1) depth) where majorants are k times too low
  // (THEORY.md, T3.5).
  constexpr double kMostGrowth = 20;
  const double thickest = facts != nullptr ? facts->largest_optical_thickness : 0;
  const double excess = v.density.majorant_excess, growth = 4 * (excess - 1) * thickest;
  if (growth > kMostGrowth) {
    throw Error(named(v, growing_weights(excess, thickest, growth, kMostGrowth)));
  }
  const double null = worst_null_collisions(v);
  if (!(null > kMostNullCollisions)) return;
  const double count = estimate_scatterings(thickness(v), double(largest_albedo(v)));
  const bool long_paths = count > kMostScatterings && !o.max_bounces;
  throw Error(named(v, long_paths ? scatterings(v, count) : null_collisions(v, null)));
}

void refuse_endless_paths(const RenderPlan& plan, const CameraProbe& probe) {
  // Roulette ends paths after some 4 / (1 - albedo) hits: 0.999 is about what clouds may take.
  constexpr float kWhite = 0.999f;
  const bool white = std::ranges::any_of(plan.scene.surfaces, [](const Surface& s) {
    return material_of(s).visible_light && max_component(material_of(s).albedo) > kWhite;
  });
  if (white && probe.caught() && !plan.scene.options.max_bounces) {
    throw Error(
        "most paths bounce between surfaces without losing light and would hardly end; lower the "
        "surfaces' albedo (0.8 is white paint), open the enclosure, limit the bounces with "
        "--max-bounces N, or render anyway with --force");
  }
  if (!(probe.collisions() > kMostScatterings)) return;
  const Volume& thickest = *std::max_element(
      plan.volumes.begin(), plan.volumes.end(),
      [](const Volume& a, const Volume& b) { return thickness(a) < thickness(b); });
  throw Error(named(thickest, scatterings(thickest, probe.collisions())));
}

namespace {

/// A date at which the sun of a clear sky has set, as one of another zone may be.
void warn_of_date(const Scene& scene, std::vector<std::string>& all) {
  const auto* sky = std::get_if<ClearSky>(&scene.environment);
  if (sky == nullptr || sky->date.empty()) return;
  const double elevation = sun_of(*sky).elevation;
  if (elevation > -0.3) return;
  all.push_back("at the sky's date, the sun is " + digits(-elevation, 2) +
                " degrees below the horizon, which leaves " + (elevation > -18 ? "dusk" : "night") +
                ". Check the time zone, and that longitudes east of Greenwich are positive");
}

/// Suns that shine on the side of a plane that the camera does not see.
void warn_of_suns(const Scene& scene, std::vector<std::string>& all) {
  for (const Surface& surface : scene.surfaces) {
    const auto* const plane = std::get_if<PlaneSurface>(&surface);
    if (plane == nullptr || !plane->material.visible_shadow) continue;
    const double side = dot(scene.camera.position - plane->point, plane->normal);
    int number = 0;
    for (const Light& light : scene.lights) {
      const auto* const sun = std::get_if<Sun>(&light);
      if (sun == nullptr) continue;
      ++number;
      const double sine = dot(normalize(sun->direction), normalize(plane->normal));
      if (!(sine * side < 0)) continue;
      all.push_back(
          "sun " + std::to_string(number) + " is " +
          digits(std::asin(std::abs(sine)) * 180 / std::numbers::pi, 2) +
          " degrees behind a plane that the camera looks at, which leaves the plane and all before "
          "it in its shadow. Check which axis points up, and that the direction of a sun "
          "is the way towards it");
    }
  }
}

/// A camera from which one sees hardly farther than a part of the cloud that it is in.
void warn_of_camera(const RenderPlan& plan, std::vector<std::string>& all) {
  constexpr double kFar = 0.1;  // of the cloud's size
  for (const Volume& v : plan.volumes) {
    if (v.density.octree.empty()) continue;
    const Vec3d at = plan.scene.camera.position;
    const double mu = double(extinction_in_cells(v, v.density.world_to_cells.point(at)));
    const double size = length(v.density.world_box.hi - v.density.world_box.lo);
    if (!(mu * size * kFar > 1)) continue;
    all.push_back(named(v, "the camera is inside the cloud, where light gets " + digits(1 / mu) +
                               " world units far on average; the cloud lies between " +
                               point(v.density.world_box.lo) + " and " +
                               point(v.density.world_box.hi)));
  }
}

}  // namespace

std::vector<std::string> find_warnings(const RenderPlan& plan, const CameraProbe& probe) {
  std::vector<std::string> all;
  for (const Volume& v : plan.volumes) {
    if (std::string doubt = warn_of_thickness(v); !doubt.empty()) all.push_back(std::move(doubt));
  }
  const bool any = std::any_of(plan.volumes.begin(), plan.volumes.end(),
                               [](const Volume& v) { return !v.density.octree.empty(); });
  if (any && probe.depths.empty()) all.push_back(unseen(plan, probe.rays));
  if (all.empty() && !plan.surfaces && opacity(probe) < kFaintest) {
    all.push_back("of the camera's rays through the volumes' boxes, only a fraction of " +
                  digits(opacity(probe), 2) +
                  " collides, so the picture is almost empty. Check with pvol-stats bounds for "
                  "single voxels far outside the cloud or far above its other values");
  }
  if (plan.surfaces && plan.surfaces->camera->catch_shadows() && plan.scene.options.noise) {
    all.push_back(
        "a limit on noise measures radiance only, but a shadow catcher shows mostly alpha; set the "
        "samples with --spp instead");
  }
  for (const Volume& v : plan.volumes) warn_of_motion(v, all);
  warn_of_date(plan.scene, all);
  warn_of_suns(plan.scene, all);
  warn_of_camera(plan, all);
  return all;
}

}  // namespace pvol::detail
