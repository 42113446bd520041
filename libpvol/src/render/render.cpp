// Tiles, threads and options around the path tracer.
#include "pvol/render/render.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "pvol/error.h"
#include "render/guide/importance.h"
#include "render/path/path_result.h"
#include "render/reporter.h"
#include "render/tiles/tile_renderer.h"

namespace pvol {
namespace {

using detail::PathSetup;
using detail::Reporter;
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

/// Samples [begin, end) of every pixel.
void render_pass(TileRenderer& renderer, int edge, std::uint32_t begin, std::uint32_t end,
                 Film& film, tbb::enumerable_thread_specific<Counts>& counts, Reporter& reporter) {
  const int columns = (film.crop_width + edge - 1) / edge;
  const int rows = (film.crop_height + edge - 1) / edge;
  tbb::parallel_for(std::int64_t(0), std::int64_t(columns) * rows, [&](std::int64_t i) {
    if (reporter.stop()) return;
    const int x = int(i % columns) * edge, y = int(i / columns) * edge;
    const detail::ImagePart tile{x, y, std::min(edge, film.crop_width - x),
                                 std::min(edge, film.crop_height - y)};
    if (!renderer.render(tile, begin, end, film, counts.local())) return;
    reporter.add(std::uint64_t(tile.width) * std::uint64_t(tile.height) * (end - begin));
  });
}

}  // namespace

RenderResult render(const Volume& volume, const Scene& scene, const Progress& progress) {
  return render(std::span(&volume, 1), scene, progress);
}

RenderResult render(std::span<const Volume> volumes, const Scene& scene, const Progress& progress) {
  return render(plan(volumes, scene, {.force = true, .forecast = false}), progress);
}

RenderResult render(const RenderPlan& plan, const Progress& progress, const PassDone& pass_done) {
  const RenderOptions& o = plan.scene.options;
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

  PathSetup setup(plan);
  setup.stop = &reporter.stop();
  Paths paths = plan.kernel.paths;
  if (paths == Paths::guided) {
    const std::clock_t begin = std::clock();
    arena.execute([&] { detail::guide_paths(plan, setup); });
    result.guide_seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
    result.guided = setup.importance != nullptr;
    if (!result.guided) paths = Paths::one_volume;  // nothing to be guided by
  }
  if (!std::isfinite(setup.shadow_unit)) {
    throw Error("the lights are too bright for single precision");
  }
  TileRenderer renderer(plan, setup, paths);
  film.layers = detail::make_layers(setup);
  for (Layer& layer : film.layers) layer.sums.resize(film.pixels.size());

  const std::uint64_t last = std::uint64_t(o.first_sample) + o.samples;
  if (last > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("samples up to number " + std::to_string(last) +
                " are asked for; expected at most 4294967295");
  }

  // In passes, the first of them short, so that an image that is stopped has samples everywhere.
  constexpr std::uint64_t kLongestPass = 16;
  std::uint64_t pass = 1;
  for (std::uint32_t begin = o.first_sample; begin < last && !reporter.stop();) {
    const std::uint32_t end = begin + std::uint32_t(std::min(pass, last - begin));
    const int edge = renderer.edge(end - begin, film, threads);
    arena.execute([&] { render_pass(renderer, edge, begin, end, film, counts, reporter); });
    pass = std::min(2 * pass, kLongestPass);
    begin = end;
    if (pass_done && begin < last && !reporter.stop()) pass_done(film);
  }
  for (const Counts& c : counts) result.counts += c;
  result.complete = reporter.finish();
  return result;
}

}  // namespace pvol
