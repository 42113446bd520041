#include "render/plan/camera_probe.h"

#include <algorithm>
#include <cmath>

#include "pvol/bounds/walk.h"
#include "pvol/volume/extinction_source.h"
#include "render/engine/tiles/render_tile.h"
#include "render/path/camera_rays.h"
#include "render/path/traversal.h"

namespace pvol::detail {
namespace {

constexpr int kRaysAlong = 24;                 // each edge of the image
constexpr std::uint64_t kMostSteps = 1 << 20;  // of all paths
constexpr std::uint32_t kMostBounces = 256;    // of a path

/// Optical depth of a ray through an instance of a volume by one look-up in each segment, right on
/// average; nothing where it misses the box.
[[nodiscard]] std::optional<double> sample_depth(const VolumeSetup& v, const Instance& at,
                                                 const Ray& world, double limit, Rng& rng) {
  const Ray ray = at.in_cells(world);
  const auto span = v.in_box(ray);
  if (!span || !(span->t0 < limit)) return std::nullopt;
  const VolumeField& f = v.volume.density;
  return visit_source(f, [&](const auto& mu) {
    Walk walk(f.octree, make_cursor(f.octree, ray.at(span->t0)), at.in_cells(Vec3f(world.d)),
              limit - span->t0);
    double depth = 0;
    while (const auto s = walk.next()) {
      const double length = s->t1 - s->t0;
      depth += double(mu(*s, walk.point(s->t0 + double(rng.uniform()) * length))) * length;
    }
    return depth;
  });
}

[[nodiscard]] std::optional<double> sample_depth(const PathSetup& setup, const Ray& ray, Rng& rng) {
  std::optional<double> sum;
  const Instances& in = *setup.instances;
  const double frames = in.moves() ? setup.view.camera.shutter.at(double(rng.uniform())) : 0;
  const double end =
      setup.surfaces ? setup.surfaces->camera->first_hit(ray, kEndless).distance : kEndless;
  in.tree.visit(ray, end, [&](std::uint32_t i, double limit) {
    const Instance at = in.at_time(i, frames);
    const VolumeSetup& v = setup.volumes[at.volume];
    const auto depth = sample_depth(v, at, ray, limit, rng);
    if (depth) sum = sum.value_or(0) + *depth;
    return limit;
  });
  return sum;
}

[[nodiscard]] std::uint64_t steps(const Counts& c) {
  const auto of = [](const Tally& t) {
    return t.segments + t.bounds_tests + t.lookups + t.null_collisions;
  };
  return of(c.path) + of(c.shadow) + c.collisions + c.shadow_rays + c.surface_hits;
}

}  // namespace

RenderPlan plain_plan(const RenderPlan& plan) {
  RenderPlan p;
  p.volumes = plan.volumes;
  p.shells = plan.shells;
  p.kernel = plan.kernel;
  p.emission = plan.emission;
  p.surfaces = plan.surfaces;
  p.kernel.count = true;
  p.kernel.kind = KernelKind::scalar;
  p.kernel.paths = plain(plan.kernel.paths);
  p.scene.camera = plan.scene.camera;
  p.lighting = plan.lighting;
  p.scene.options = plan.scene.options;
  p.scene.options.first_sample = ~0u - 1;  // one that hardly any picture has
  p.scene.options.aovs = {};
  p.scene.options.max_bounces =
      std::min(kMostBounces, plan.scene.options.max_bounces.value_or(kMostBounces));
  return p;
}

int count_pixels(const RenderPlan& plan) {
  const ImagePart part = image_part(plan.scene.options);
  return std::min(kRaysAlong, part.width) * std::min(kRaysAlong, part.height);
}

void follow_paths(const RenderPlan& plan, const PathSetup& setup, int paths, CameraProbe& probe,
                  const std::function<void(Rgb)>& visit) {
  constexpr int kProbeStride = 229;  // a prime above kRaysAlong: all are met
  const TileFunction render_part = find_tile_function(plan.kernel.paths, setup);
  const ImagePart part = image_part(plan.scene.options);
  const int across = std::min(kRaysAlong, part.width), down = std::min(kRaysAlong, part.height);
  Film film;
  film.width = plan.scene.options.width, film.height = plan.scene.options.height;
  film.crop_width = film.crop_height = 1;
  film.pixels.resize(1);
  for (; probe.paths < paths && steps(probe.counts) < kMostSteps; ++probe.paths) {
    const int i = int(std::int64_t(probe.paths) * kProbeStride % (across * down));
    film.x = part.x + int(std::int64_t(part.width) * (i % across) / across);
    film.y = part.y + int(std::int64_t(part.height) * (i / across) / down);
    film.first_sample =
        plan.scene.options.first_sample - std::uint32_t(probe.paths / (across * down));
    Counts path;
    film.pixels[0] = {};
    start_sums(film);
    (void)render_part(setup, {0, 0, 1, 1}, {.all = 1}, film, path);
    probe.counts += path;
    if (path.collisions > kMostBounces) probe.cut_counts += path;
    const bool cut = path.surface_hits + path.collisions > kMostBounces;
    if (cut && path.surface_hits > path.collisions) ++probe.caught;
    visit(Rgb(mean(film.pixels[0])));
  }
}

double CameraProbe::collisions() const {
  constexpr std::uint64_t kEnough = 100;  // for the mean of the paths to stand on its own
  const bool whole = counts.collisions >= kEnough && cut_counts.collisions == 0;
  return whole ? followed() : std::max(followed(), by_depth);
}

CameraProbe probe_camera(const RenderPlan& plan) {
  constexpr std::uint64_t kKey = 0x666f726563617374;
  const RenderOptions& o = plan.scene.options;
  const RenderPlan unguided = plain_plan(plan);
  const PathSetup setup(unguided);
  double albedo = 0;
  for (const Volume& v : plan.volumes) {
    albedo = std::max(albedo, double(largest_albedo(v)));
  }
  CameraProbe probe;
  double sum = 0;
  visit_coarse_rays(setup.view.projection, image_part(o), kRaysAlong, [&](const Ray& ray, int i) {
    ++probe.rays;
    Rng rng(kKey, 0, std::uint64_t(i));
    const auto depth = sample_depth(setup, ray, rng);
    if (!depth) return;
    probe.depths.push_back(*depth);
    double scatterings = estimate_scatterings(*depth, albedo);
    if (o.max_bounces) scatterings = std::min(scatterings, double(*o.max_bounces) + 1);
    sum += -std::expm1(-*depth) * scatterings;
  });
  probe.by_depth = sum / probe.rays;
  if (plan.kernel.endless) return probe;
  follow_paths(unguided, setup, count_pixels(unguided), probe, [](Rgb) {});
  return probe;
}

}  // namespace pvol::detail
