#include "render/plan/camera_probe.h"

#include <algorithm>
#include <cmath>

#include "pvol/volume/extinction_source.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/path/camera_rays.h"
#include "render/path/film_layers.h"
#include "render/path/first_collision.h"

namespace pvol::detail {
namespace {

constexpr std::uint64_t kMostSteps = 1 << 20;  // of all paths

/// Optical depth of a ray through an instance of a volume by one look-up in each segment, right on
/// average; nothing where it misses the box.
[[nodiscard]] std::optional<double> sample_depth(const VolumeSetup& v, const Instance& at,
                                                 const Ray& world, double limit, Rng& rng) {
  const auto span = v.in_box(at.in_cells(world));
  if (!span || !(span->t0 < limit)) return std::nullopt;
  const VolumeField& f = v.volume.density;
  return visit_source(f, [&](const auto& mu) {
    Walk walk = walk_through(v, at, world, span->t0, limit - span->t0);
    double depth = 0;
    while (const auto s = walk.next()) {
      const double length = s->t1 - s->t0;
      depth += double(mu(*s, walk.point(s->t0 + double(rng.uniform()) * length))) * length;
    }
    return depth;
  });
}

[[nodiscard]] std::uint64_t steps(const Counts& c) {
  const auto of = [](const Tally& t) {
    return t.segments + t.bounds_tests + t.lookups + t.null_collisions;
  };
  return of(c.path) + of(c.shadow) + c.collisions + c.shadow_rays + c.surface_hits;
}

}  // namespace

std::optional<double> sample_depth(const PathSetup& setup, const Ray& ray, double limit, Rng& rng) {
  std::optional<double> sum;
  const Instances& in = *setup.instances;
  const bool moves = in.moves() || (setup.surfaces && setup.surfaces->move());
  const double frames = moves ? setup.view.camera.shutter.at(double(rng.uniform())) : 0;
  if (setup.surfaces) {
    limit = std::min(limit, setup.surfaces->camera->first_hit(ray, limit, float(frames)).distance);
  }
  in.tree.visit(ray, limit, [&](std::uint32_t i, double end) {
    const Instance at = in.at_time(i, frames);
    const VolumeSetup& v = setup.volumes[at.volume];
    const auto depth = sample_depth(v, at, ray, end, rng);
    if (depth) sum = sum.value_or(0) + *depth;
    return end;
  });
  return sum;
}

RenderPlan plain_plan(const RenderPlan& plan) {
  RenderPlan p;
  p.volumes = plan.volumes;
  p.shells = plan.shells;
  p.kernel = plan.kernel;
  p.one_by_one = plan.one_by_one;
  p.emission = plan.emission;
  p.surfaces = plan.surfaces;
  p.kernel.count = true;
  p.scene.camera = plan.scene.camera;
  p.lighting = plan.lighting;
  p.scene.options = plan.scene.options;
  p.scene.options.first_sample = ~0u - 1;  // one that hardly any picture has
  p.scene.options.aovs = {};
  p.scene.options.max_bounces =
      std::min(kMostProbed, plan.scene.options.max_bounces.value_or(kMostProbed));
  return p;
}

RenderPlan plain_plan_of_whole(const RenderPlan& plan) {
  RenderPlan p = plain_plan(plan);
  RenderOptions& o = p.scene.options;
  o.crop_x = o.crop_y = o.crop_width = o.crop_height = 0;
  return p;
}

void follow_paths(const PathSetup& setup, int paths, CameraProbe& probe,
                  const std::function<void(const Film&, std::size_t)>& visit,
                  const std::function<bool()>& enough) {
  constexpr int kPathsAtOnce = 64;
  const PathSetup small = setup.in_small(kRaysAlong * kRaysAlong);
  TileRenderer tiles(small);
  Film film = make_film(small.options);
  for (; probe.paths < paths && steps(probe.counts) < kMostSteps; --film.first_sample) {
    film.pixels.assign(film.pixels.size(), {});
    film.layers = make_layers(small, film.pixels.size());
    keep_exact_sums(film);
    film.counts.assign(film.pixels.size(), {});
    const int rows = std::max(1, kPathsAtOnce / film.crop_width);
    for (int y = 0; y < film.crop_height && steps(probe.counts) < kMostSteps; y += rows) {
      const ImagePart tile{0, y, film.crop_width, std::min(rows, film.crop_height - y)};
      (void)tiles.render(tile, {.all = 1}, film, probe.counts);
      probe.paths += tile.width * tile.height;
      for (int x = 0; x < tile.width * tile.height; ++x) {
        const std::size_t pixel = film.index(0, y) + std::size_t(x);
        probe.cut |= film.count(pixel, PixelCounter::collisions) > kMostProbed;
        visit(film, pixel);
      }
    }
    if (enough()) return;
  }
}

bool CameraProbe::caught() const {
  return counts.surface_hits > counts.collisions &&
         2 * counts.surface_hits > std::uint64_t(paths) * kMostProbed;
}

double CameraProbe::collisions() const {
  constexpr std::uint64_t kEnough = 100;  // for the mean of the paths to stand on its own
  const bool whole = counts.collisions >= kEnough && !cut;
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
    const auto depth = sample_depth(setup, ray, kEndless, rng);
    if (!depth) return;
    probe.depths.push_back(*depth);
    double scatterings = estimate_scatterings(*depth, albedo);
    if (o.max_bounces) scatterings = std::min(scatterings, double(*o.max_bounces) + 1);
    sum += -std::expm1(-*depth) * scatterings;
  });
  probe.by_depth = sum / probe.rays;
  if (plan.kernel.endless) return probe;
  follow_paths(setup, 1, probe, [](const Film&, std::size_t) {});
  return probe;
}

}  // namespace pvol::detail
