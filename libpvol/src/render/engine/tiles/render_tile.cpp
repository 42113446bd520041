#include "render/engine/tiles/render_tile.h"

#include "render/engine/guided_tracer.h"
#include "render/engine/path_tracer.h"
#include "render/engine/surface_tracer.h"
#include "render/path/chromatic_volume.h"
#include "render/path/film_layers.h"

namespace pvol::detail {
namespace {

/// What a tracer has done so far.
template <class Tracer>
[[nodiscard]] Counts counts_of(const Tracer& tracer) {
  const auto& work = tracer.traversal.work;
  Counts c;
  c.path = work.path;
  c.shadow = work.shadow;
  c.collisions = tracer.collisions;
  c.shadow_rays = tracer.shadow_rays;
  c.shell_tests = work.shell_tests;
  c.shell_rejections = work.shell_rejections;
  if constexpr (Tracer::kHasSurfaces) c.surface_hits = tracer.surface_hits;
  return c;
}

/// A pixel's samples are summed in their order, whatever the tiles and threads.
template <class Tracer>
bool render_tile(const PathSetup& setup, const ImagePart& tile, const SampleTargets& targets,
                 Film& film, Counts& counts) {
  Tracer tracer(setup);
  Counts before;
  const auto count_pixel = [&](PixelSums& p) {
    const Counts now = counts_of(tracer);
    for (std::size_t k = 0; k < kPixelCounts.size(); ++k) {
      p.counts[k] += kPixelCounts[k].of(now) - kPixelCounts[k].of(before);
    }
    before = now;
  };
  bool whole = true;
  for (int y = tile.y; whole && y != tile.y + tile.height; ++y) {
    for (int x = tile.x; whole && x != tile.x + tile.width; ++x) {
      const std::size_t pixel = film.index(x, y);
      const std::uint32_t end = targets.of(pixel);
      for (std::uint32_t k = film.pixels[pixel].samples; k < end; ++k) {
        const PathResult& r = tracer.trace(film.x + x, film.y + y, film.first_sample + k);
        if (setup.stop->load(std::memory_order_relaxed)) {
          whole = false;
          break;
        }
        require_finite(r, film.x + x, film.y + y);
        add_sample(setup, r, pixel, film);
        // One by one, for the work of a sample that was given up does not count.
        if (setup.count) count_pixel(film.pixels[pixel]);
      }
      flush(film, pixel);
    }
  }
  if (setup.count) counts += before;
  return whole;
}

/// Paths through the places that the setup has.
template <template <class, class> class Tracer, class Traversal>
[[nodiscard]] TileFunction find(const PathSetup& setup) {
  return are_simple(setup) ? &render_tile<Tracer<Traversal, SimplePaths>>
                           : &render_tile<Tracer<Traversal, AnyPaths>>;
}

}  // namespace

TileFunction find_tile_function(Paths paths, const PathSetup& setup) {
  switch (paths) {
    case Paths::guided:
      return find<GuidedTracer, OneVolume>(setup);
    case Paths::guided_many:
      return find<GuidedTracer, ManyVolumes>(setup);
    case Paths::many_volumes:
      return find<PathTracer, ManyVolumes>(setup);
    case Paths::guided_moving:
      return &render_tile<GuidedTracer<MovingVolumes>>;
    case Paths::moving_places:
      return &render_tile<PathTracer<MovingVolumes>>;
    case Paths::surfaces:
      return setup.instances->moves() ? &render_tile<SurfaceTracer<MovingPlacesAt>>
                                      : &render_tile<SurfaceTracer<StillPlaces>>;
    case Paths::chromatic:
      return &render_tile<PathTracer<ChromaticVolume>>;
    case Paths::one_volume:
      break;
  }
  return find<PathTracer, OneVolume>(setup);
}

}  // namespace pvol::detail
