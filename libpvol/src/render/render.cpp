// Tiles, threads and options around the path tracer.
#include "pvol/render/render.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>

#include "pvol/error.h"
#include "render/guide/importance.h"
#include "render/passes.h"
#include "render/path/film_layers.h"
#include "render/reporter.h"
#include "render/tiles/tile_renderer.h"

namespace pvol {
namespace {

using detail::Passes;
using detail::PathSetup;
using detail::Reporter;
using detail::Targets;
using detail::TileRenderer;

Film make_film(const RenderOptions& o) {
  Film f;
  f.width = o.width, f.height = o.height;
  const detail::ImagePart part = detail::image_part(o);
  f.x = part.x, f.y = part.y;
  f.crop_width = part.width, f.crop_height = part.height;
  f.pixels.resize(std::size_t(f.crop_width) * std::size_t(f.crop_height));
  return f;
}

double seconds_since(std::chrono::steady_clock::time_point t) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
}

/// The same paths, counted.
PathSetup with_counts(const RenderPlan& plan, const PathSetup& setup) {
  PathSetup counted = setup;
  counted.count = true;
  if (!plan.kernel.watched) {
    counted.flights =
        detail::find_flights(detail::field_kind(plan.kernel), detail::Watching::count);
  }
  return counted;
}

/// Samples of a part of the film.
std::uint64_t count_samples(const Film& film, const detail::ImagePart& part) {
  std::uint64_t n = 0;
  for (int y = part.y; y != part.y + part.height; ++y) {
    for (int x = part.x; x != part.x + part.width; ++x) n += film.at(x, y).samples;
  }
  return n;
}

bool reaches(const Film& film, const Targets& targets) {
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    if (film.pixels[i].samples < targets.of(i)) return false;
  }
  return true;
}

/// Renders tile by tile, on all threads of the arena that it is called in.
class PassRenderer {
 public:
  PassRenderer(const RenderPlan& plan, const PathSetup& setup, Paths paths)
      : tiles_(plan, setup, paths) {}

  /// Brings every pixel to its target, unless the reporter says stop.
  void render(const Targets& targets, int threads, Film& film, Reporter& reporter) {
    const int edge = tiles_.edge(targets, film, threads);
    const int columns = (film.crop_width + edge - 1) / edge;
    const int rows = (film.crop_height + edge - 1) / edge;
    tbb::parallel_for(std::int64_t(0), std::int64_t(columns) * rows, [&](std::int64_t i) {
      if (reporter.stop()) return;
      const int x = int(i % columns) * edge, y = int(i / columns) * edge;
      const detail::ImagePart tile{x, y, std::min(edge, film.crop_width - x),
                                   std::min(edge, film.crop_height - y)};
      const std::uint64_t before = count_samples(film, tile);
      if (!tiles_.render(tile, targets, film, counts_.local())) return;
      reporter.add(count_samples(film, tile) - before);
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

/// Guides the setup's paths where the plan says so; what paths it is then for.
Paths guide(const RenderPlan& plan, PathSetup& setup, RenderResult& result) {
  Paths paths = plan.kernel.paths;
  if (plan.guide.used) {
    const std::clock_t begin = std::clock();
    detail::guide_paths(plan, setup);
    result.guide_seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
    result.guided = setup.importance != nullptr;
    if (!result.guided) paths = plain(paths);  // nothing to be guided by
  }
  if (!std::isfinite(setup.shadow_unit)) {
    throw Error("the lights are too bright for single precision");
  }
  return paths;
}

void check_sample_numbers(const RenderOptions& o) {
  const std::uint64_t last =
      std::uint64_t(o.first_sample) + (by_need(o) ? detail::kMostOfPixel : o.samples);
  if (last <= std::numeric_limits<std::uint32_t>::max()) return;
  throw Error("samples up to number " + std::to_string(last) +
              " are asked for; expected at most 4294967295");
}

}  // namespace

RenderResult render(const Volume& volume, const Scene& scene, const Progress& progress) {
  return render(std::span(&volume, 1), scene, progress);
}

RenderResult render(std::span<const Volume> volumes, const Scene& scene, const Progress& progress) {
  return render(plan(volumes, scene, {.force = true, .forecast = false}), progress);
}

RenderResult render(const RenderPlan& plan, const Progress& progress, const PassDone& pass_done) {
  const auto begin = std::chrono::steady_clock::now();
  const RenderOptions& o = plan.scene.options;
  check_sample_numbers(o);
  RenderResult result;
  Film& film = result.film;
  film = make_film(o);
  Passes passes(o, film.pixels.size());
  Reporter reporter(progress, passes.total());
  const int threads = o.threads > 0 ? o.threads : tbb::this_task_arena::max_concurrency();
  // The control is the process's: it may only raise the limit, for more threads than there are
  // cores.
  constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
  const tbb::global_control allow(
      kLimit, std::max(std::size_t(threads), tbb::global_control::active_value(kLimit)));
  tbb::task_arena arena(threads);

  PathSetup setup(plan);
  setup.stop = &reporter.stop();
  const Paths paths = arena.execute([&] { return guide(plan, setup, result); });
  film.layers = detail::make_layers(setup, film.pixels.size());
  film.deep = detail::make_deep(setup, film.pixels.size());

  // Samples by need follow costs, too: their pilot is counted.
  const bool counts_pilot = by_need(o) && !setup.count;
  std::optional<PathSetup> counted;
  if (counts_pilot) counted.emplace(with_counts(plan, setup));
  std::optional<PassRenderer> renderer;
  renderer.emplace(plan, counted ? *counted : setup, paths);
  std::optional<Targets> targets;
  for (bool any = false; (targets = passes.next(film, seconds_since(begin))); any = true) {
    if (reporter.stop()) break;
    if (any && pass_done) pass_done(film);
    reporter.expect(passes.total());
    if (counts_pilot && !targets->each.empty()) renderer.emplace(plan, setup, paths);
    arena.execute([&] { renderer->render(*targets, threads, film, reporter); });
    if (!reaches(film, *targets)) break;
  }
  if (setup.count) {
    result.counts = renderer->counts();
  } else {
    for (PixelSums& p : film.pixels) p.counts = {};
  }
  result.complete = !targets;
  reporter.finish();
  return result;
}

}  // namespace pvol
