// Tiles, threads and options around the kernels.
#include "pvol/render/render.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>

#include "math/workers.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"
#include "render/engine/estimate_pixels.h"
#include "render/engine/passes.h"
#include "render/engine/reporter.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/engine/time_paths.h"
#include "render/film/window.h"
#include "render/guide/importance.h"
#include "render/path/film_layers.h"

namespace pvol {
namespace {

using detail::count_samples;
using detail::have_same_window;
using detail::keep_counts;
using detail::make_film;
using detail::Passes;
using detail::PathSetup;
using detail::Reporter;
using detail::SampleTargets;
using detail::TileRenderer;
using detail::Workers;

/// Of an earlier render: the empty film `fresh` with what that one has.
Film continued(Film fresh, Film earlier) {
  if (earlier.pixels.empty()) return fresh;
  bool same = have_same_window(fresh, earlier) && earlier.color_space == fresh.color_space &&
              !earlier.remainders.empty() && earlier.pixels.size() == fresh.pixels.size() &&
              earlier.layers.size() == fresh.layers.size() &&
              earlier.first_sample == fresh.first_sample && fresh.deep.pixels.empty();
  for (std::size_t k = 0; same && k < fresh.layers.size(); ++k) {
    same = earlier.layers[k].name == fresh.layers[k].name &&
           earlier.layers[k].sums.size() == fresh.layers[k].sums.size() &&
           earlier.layers[k].weights.size() == fresh.layers[k].weights.size();
    earlier.layers[k].least = fresh.layers[k].least;
  }
  if (same) return earlier;
  throw Error(
      "the film to resume belongs to another picture; expected the same size, crop, colour "
      "space, layers and first sample");
}

double seconds_since(std::chrono::steady_clock::time_point t) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
}

bool reaches(const Film& film, const SampleTargets& targets) {
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    if (film.pixels[i].samples < targets.of(i)) return false;
  }
  return true;
}

/// Renders tile by tile, on all threads of the arena that it is called in.
class PassRenderer {
 public:
  explicit PassRenderer(const PathSetup& setup) : tiles_(setup) {}

  /// Brings every pixel to its target, unless the reporter says stop or pause.
  void render(const SampleTargets& targets, int threads, Film& film, Reporter& reporter) {
    const int edge = tiles_.edge(targets, film, threads);
    const int columns = (film.crop_width + edge - 1) / edge;
    const int rows = (film.crop_height + edge - 1) / edge;
    parallel_for(0, std::size_t(columns) * std::size_t(rows), [&](std::size_t i) {
      if (reporter.pause()) return;
      const int x = int(i % std::size_t(columns)) * edge, y = int(i / std::size_t(columns)) * edge;
      const detail::ImagePart tile{x, y, std::min(edge, film.crop_width - x),
                                   std::min(edge, film.crop_height - y)};
      const std::uint64_t before = count_samples(film, tile);
      if (!tiles_.render(tile, targets, film, counts_.local())) return;
      // Tiles that were done before a pause are no news: it would pause again for ever.
      const std::uint64_t added = count_samples(film, tile) - before;
      if (added > 0) reporter.add(added);
    });
  }

  /// What all passes took; where the setup counts.
  [[nodiscard]] Counts counts() const {
    Counts sum;
    for (const Counts& c : counts_) sum += c;
    return sum;
  }

 private:
  TileRenderer tiles_;
  tbb::enumerable_thread_specific<Counts> counts_;
};

/// Guides the setup's paths where the plan says so.
void guide(const RenderPlan& plan, PathSetup& setup, RenderResult& result) {
  if (plan.guide.used) {
    const std::clock_t begin = std::clock();
    detail::guide_paths(plan, setup);
    if (setup.importance) setup.pixel_importance = detail::estimate_pixel_importance(setup);
    result.guide_seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
    result.guided = setup.importance != nullptr;
  }
  if (!std::isfinite(setup.light.shadow_unit)) {
    throw Error("the lights are too bright for single precision; scale them down");
  }
}

/// For what the result's film lacks.
TimeForecast forecast(const RenderPlan& plan, const PathSetup& setup, tbb::task_arena& arena,
                      const RenderResult& result) {
  const RenderOptions& o = plan.scene.options;
  const detail::ImagePart part = detail::image_part(o);
  const double all = double(part.width) * part.height * samples_of_part(o);
  const double done =
      double(count_samples(result.film, {0, 0, result.film.crop_width, result.film.crop_height}));
  TimeForecast f{.guide_seconds = result.guide_seconds,
                 .samples = std::max(0.0, all - done),
                 .threads = arena.max_concurrency()};
  if (f.samples <= 0) return f;
  try {
    const detail::TimedPaths timed =
        arena.execute([&] { return detail::time_paths(setup, f.samples); });
    f.sample_seconds = timed.seconds_of_path();
    f.own_seconds = timed.seconds + timed.cold_seconds;
  } catch (const Error&) {  // the render meets it, too, and names its pixel
  }
  return f;
}

void check_sample_numbers(const RenderOptions& o) {
  const std::uint64_t last =
      std::uint64_t(o.first_sample) + (is_adaptive(o) ? detail::kMostOfPixel : o.samples);
  if (last <= std::numeric_limits<std::uint32_t>::max()) return;
  throw Error("the samples have numbers up to " + std::to_string(last) +
              "; expected at most 4294967295: lower the first sample or the number of samples");
}

/// Gives the empty film its layers and what an earlier render left.
void begin_film(const PathSetup& setup, Film earlier, Passes& passes, Reporter& reporter,
                Film& film) {
  film = continued(make_film(setup), std::move(earlier));
  if (setup.count) keep_counts(film);
  passes.resume(film);
  reporter.add(count_samples(film, {0, 0, film.crop_width, film.crop_height}));
}

/// What all passes of a render share.
struct Job {
  const RenderPlan& plan;
  const PathSetup& setup;
  int threads;
  tbb::task_arena& arena;
  const RenderCallbacks& callbacks;
  std::chrono::steady_clock::time_point begin;
};

/// Renders pass by pass until the film has all samples or the reporter says stop: whether it has.
bool render_passes(const Job& job, Passes& passes, Reporter& reporter, RenderResult& result) {
  Film& film = result.film;
  const bool adaptive = is_adaptive(job.plan.scene.options);
  // Adaptive samples follow costs, too: their pilot is counted.
  const bool counts_pilot = adaptive && !job.setup.count && !film.needs;
  std::optional<PathSetup> counted;
  if (counts_pilot) counted.emplace(job.setup).count = true, keep_counts(film);
  std::optional<PassRenderer> renderer;
  renderer.emplace(counted ? *counted : job.setup);
  std::optional<SampleTargets> targets;
  for (bool any = false; (targets = passes.next(film, seconds_since(job.begin))); any = true) {
    if (reporter.stop()) break;
    if (any && job.callbacks.pass_done) job.callbacks.pass_done(film);
    reporter.expect(passes.total());
    if (counts_pilot && !targets->each.empty()) renderer.emplace(job.setup);
    make_room(targets->most(), film);
    for (;;) {
      job.arena.execute([&] { renderer->render(*targets, job.threads, film, reporter); });
      if (reporter.stop() || reaches(film, *targets)) break;
      if (reporter.take_pause() && job.callbacks.pass_done) job.callbacks.pass_done(film);
    }
    if (!reaches(film, *targets)) break;
  }
  if (job.setup.count) result.counts = renderer->counts();
  // The pilot's counts are no longer wanted once the needs are known.
  const bool pilot = adaptive && !film.needs;
  if (!job.setup.count && !pilot) film.counts = {};
  return !targets;
}

}  // namespace

RenderResult render(const Volume& volume, const Scene& scene, const Progress& progress) {
  return render(std::span(&volume, 1), scene, progress);
}

RenderResult render(std::span<const Volume> volumes, const Scene& scene, const Progress& progress) {
  return render(plan(volumes, scene, {.force = true, .forecast = false}), progress);
}

RenderResult render(const RenderPlan& plan, const Progress& progress, const PassDone& pass_done) {
  return resume(plan, {}, {progress, pass_done, {}});
}

Film begin_by_pilot(const RenderPlan& plan, const Film& pilot) {
  const RenderOptions& o = plan.scene.options;
  const Film part = make_film(o);
  const bool has_part = pilot.color_space == o.color_space && pilot.width == o.width &&
                        pilot.height == o.height && pilot.x <= part.x && pilot.y <= part.y &&
                        pilot.x + pilot.crop_width >= part.x + part.crop_width &&
                        pilot.y + pilot.crop_height >= part.y + part.crop_height;
  const auto is_done = [](const PixelSums& p) { return p.samples == kPilot; };
  if (!has_part || !is_adaptive(o) || !std::ranges::all_of(pilot.pixels, is_done)) {
    throw Error(
        "the pilot does not fit this picture; expected all of a picture with adaptive samples, "
        "with " +
        std::to_string(kPilot) + " samples in each pixel");
  }
  Film film = crop_of(pilot, part.x, part.y, part.crop_width, part.crop_height);
  film.needs = detail::needs_of_part(detail::find_adaptive_samples(pilot, o.noise), pilot, part);
  return film;
}

TimeForecast forecast_time(const RenderPlan& plan) {
  Workers workers(plan.scene.options.threads);
  PathSetup setup(plan);
  RenderResult result;
  workers.arena.execute([&] { guide(plan, setup, result); });
  return forecast(plan, setup, workers.arena, result);
}

RenderResult resume(const RenderPlan& plan, Film earlier, const RenderCallbacks& callbacks) {
  const auto begin = std::chrono::steady_clock::now();
  const RenderOptions& o = plan.scene.options;
  check_sample_numbers(o);
  RenderResult result;
  const detail::ImagePart part = detail::image_part(o);
  Passes passes(o, std::size_t(part.width) * std::size_t(part.height));
  Reporter reporter(callbacks, passes.total());
  Workers workers(o.threads);
  PathSetup setup(plan);
  setup.stop = &reporter.stop();
  workers.arena.execute([&] { guide(plan, setup, result); });
  begin_film(setup, std::move(earlier), passes, reporter, result.film);
  if (callbacks.forecast) {
    callbacks.forecast(forecast(plan, setup, workers.arena, result));
  }
  const Job job{plan, setup, workers.threads, workers.arena, callbacks, begin};
  result.complete = render_passes(job, passes, reporter, result);
  result.goal = passes.total();
  reporter.finish();
  return result;
}

}  // namespace pvol
