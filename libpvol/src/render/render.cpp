// Tiles, threads and options around the path tracer.
#include "pvol/render/render.h"

#include <tbb/blocked_range2d.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <mutex>
#include <string>

#include "pvol/error.h"
#include "pvol/render/guide_choice.h"
#include "pvol/volume/estimators.h"
#include "render/guide/importance.h"
#include "render/tiles/render_tile.h"

namespace pvol {
namespace {

using detail::PathSetup;
using detail::TileFunction;

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

void check(const Scene& scene) {
  validate(scene.environment);
  for (const Light& light : scene.lights) validate(light);
  validate(scene.options);
  validate(scene.camera);
}

Film make_film(const RenderOptions& o) {
  Film f;
  f.width = o.width, f.height = o.height;
  f.x = o.crop_x, f.y = o.crop_y;
  f.crop_width = o.crop_width ? o.crop_width : o.width - o.crop_x;
  f.crop_height = o.crop_height ? o.crop_height : o.height - o.crop_y;
  f.pixels.resize(std::size_t(f.crop_width) * std::size_t(f.crop_height));
  return f;
}

/// Reports progress from one thread at a time and remembers a wish to stop.
class Reporter {
 public:
  Reporter(const Progress& progress, std::uint64_t total) : progress_(progress), total_(total) {}

  void add(std::uint64_t samples) {
    done_ += samples;
    if (!progress_) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && !progress_(done_, total_)) stop_ = true;
  }
  /// The last report, when no thread is at work; whether all is done.
  bool finish() {
    if (progress_) (void)progress_(done_, total_);
    return done_ == total_;
  }
  [[nodiscard]] bool stopped() const { return stop_; }

 private:
  const Progress& progress_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_ = 0;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;
};

void check(const Volume& volume, const RenderOptions& o) {
  validate(volume.medium);
  require(volume.density.majorant_excess == 1 || is_weighted(o.tracker),
          "the volume's majorants do not hold, which takes a tracker with weights");
  const bool cells = o.look_up == LookUp::nearest || o.look_up == LookUp::trilinear;
  require(cells || (o.tracker != Tracker::regular && o.transmittance != Transmittance::regular),
          "regular tracking and regular transmittance have closed forms for nearest and trilinear "
          "interpolation only; choose another tracker, transmittance or interpolation");
  require(volume.density.scale == float(volume.medium.extinction) &&
              volume.density.look_up == o.look_up &&
              (o.tracker != Tracker::delta_global || volume.density.octree.depth == 0),
          "the volume was made for another extinction, interpolation or tracker than the scene's");
}

/// One field for all volumes: micro-bounds where all have them, but for empty ones.
TileFunction choose_tile_function(std::span<const Volume> volumes, const RenderOptions& o,
                                  bool guided) {
  int edge = 0;
  for (const Volume& v : volumes) edge = std::max(edge, v.density.micro.edge);
  const bool squeezed = edge > 0 && std::all_of(volumes.begin(), volumes.end(), [&](const auto& v) {
                          return v.density.octree.empty() || v.density.micro.edge == edge;
                        });
  if (guided) {
    return squeezed ? detail::guided_squeezed_tile_function(o.look_up, edge, o.count)
                    : detail::guided_tile_function(o.look_up, o.count);
  }
  const bool many = volumes.size() > 1;
  if (o.look_up == LookUp::tricubic) {
    return detail::tricubic_tile_function(squeezed ? edge : 0, many, o.count);
  }
  if (o.look_up == LookUp::procedural) {
    return detail::procedural_tile_function(squeezed ? edge : 0, many, o.count);
  }
  return squeezed ? detail::squeezed_tile_function(o.look_up, edge, many, o.count)
                  : detail::plain_tile_function(o.look_up, many, o.count);
}

}  // namespace

RenderResult render(const Volume& volume, const Scene& scene, const Progress& progress) {
  return render(std::span(&volume, 1), scene, progress);
}

RenderResult render(std::span<const Volume> volumes, const Scene& wanted,
                    const Progress& progress) {
  check(wanted);
  Scene scene = wanted;
  RenderOptions& o = scene.options;
  require(!volumes.empty(), "there is no volume to render");
  require(volumes.size() == 1 || !is_weighted(o.tracker),
          "weighted trackers take one volume; choose another tracker for several");
  if (o.transmittance == Transmittance::automatic) {
    o.transmittance = choose_transmittance(volumes).estimator;
  }
  for (const Volume& v : volumes) check(v, o);
  RenderResult result;
  result.film = make_film(o);
  Film& film = result.film;
  Reporter reporter(progress, std::uint64_t(film.pixels.size()) * o.samples);
  tbb::enumerable_thread_specific<Counts> counts;
  const int threads = o.threads > 0 ? o.threads : tbb::this_task_arena::max_concurrency();
  // The control is the process's: it may only raise the limit, for more threads than there are
  // cores.
  constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
  const tbb::global_control allow(
      kLimit, std::max(std::size_t(threads), tbb::global_control::active_value(kLimit)));
  tbb::task_arena arena(threads);

  PathSetup setup(volumes, scene);
  if (choose_guide(volumes, scene).used) {
    const std::clock_t begin = std::clock();
    const auto stopped = [&] {
      reporter.add(0);
      return reporter.stopped();
    };
    arena.execute([&] { detail::guide_paths(volumes, scene, setup, stopped); });
    result.guide_seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
  }
  result.guided = setup.importance != nullptr;
  require(std::isfinite(setup.shadow_unit), "the lights are too bright for single precision");
  const TileFunction render_part = choose_tile_function(volumes, o, result.guided);

  // In passes, so that an image that is stopped early has samples everywhere.
  constexpr std::uint32_t kPass = 16;
  constexpr std::size_t kTile = 16;
  for (std::uint32_t begin = 0; begin < o.samples && !reporter.stopped();) {
    const std::uint32_t end = begin + std::min(kPass, o.samples - begin);
    arena.execute([&] {
      tbb::parallel_for(
          tbb::blocked_range2d<int>(0, film.crop_height, kTile, 0, film.crop_width, kTile),
          [&](const tbb::blocked_range2d<int>& tile) {
            if (reporter.stopped()) return;
            render_part(setup, tile, begin, end, film, counts.local());
            reporter.add(std::uint64_t(tile.rows().size()) * tile.cols().size() * (end - begin));
          });
    });
    begin = end;
  }
  if (o.count) {
    for (const Counts& c : counts) result.counts += c;
  } else {  // paths through several volumes always count
    for (PixelSums& p : film.pixels) p.lookups = p.segments = p.collisions = 0;
  }
  result.complete = reporter.finish();
  return result;
}

Camera frame(const Box& world_box, double aspect) {
  Camera c;
  if (world_box.empty()) return c;
  constexpr double kElevation = 0.12;  // of the camera above the cloud, over its distance
  constexpr double kMargin = 1.08;
  const Vec3d forward = normalize(Vec3d(0, -kElevation, -1));
  const Vec3d right = normalize(cross(forward, c.up)), up = cross(right, forward);
  const double half_height = std::tan(c.fov / 360 * std::numbers::pi) / kMargin;
  double distance = 0;
  const Vec3d half = world_box.extent() * 0.5;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = half * Vec3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const double needed = std::max(std::abs(dot(p, up)), std::abs(dot(p, right)) / aspect);
    distance = std::max(distance, needed / half_height - dot(p, forward));
  }
  c.target = world_box.centre();
  c.position = c.target - forward * distance;
  return c;
}

double estimate_scatterings(double optical_thickness, double albedo) {
  return 1 / (1 / (1 + optical_thickness) + (1 - albedo));
}

}  // namespace pvol
