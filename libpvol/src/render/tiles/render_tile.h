// The inner part of a render: samples of the pixels of a tile, for one kind of volume and field.
#pragma once

#include <type_traits>

#include "pvol/error.h"
#include "render/guide/guided_tracer.h"
#include "render/path/path_tracer.h"
#include "render/tiles/kernels.h"

namespace pvol::detail {

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
  return c;
}

/// A pixel's samples are summed in their order, whatever the tiles and threads.
template <class Tracer, bool kCount>
void render_tile(const PathSetup& setup, const ImagePart& tile, std::uint32_t begin,
                 std::uint32_t end, Film& film, Counts& counts) {
  Tracer tracer(setup);
  Counts before;
  for (int y = tile.y; y != tile.y + tile.height; ++y) {
    for (int x = tile.x; x != tile.x + tile.width; ++x) {
      const std::size_t pixel = film.index(x, y);
      for (std::uint32_t sample = begin; sample != end; ++sample) {
        const PathResult& r = tracer.trace(film.x + x, film.y + y, sample);
        if (!is_finite(r.radiance)) {
          throw Error("pixel (" + std::to_string(film.x + x) + ", " + std::to_string(film.y + y) +
                      ") became infinite: the lights are too bright for single precision");
        }
        add_sample(r, pixel, film);
      }
      if constexpr (kCount) {
        const Counts now = counts_of(tracer);
        for (std::size_t k = 0; k < kPixelCounts.size(); ++k) {
          film.pixels[pixel].counts[k] += kPixelCounts[k].of(now) - kPixelCounts[k].of(before);
        }
        before = now;
      }
    }
  }
  if constexpr (kCount) counts += before;
}

/// For one field: paths through several volumes always count, which costs little beside them.
template <bool kGuided, class MakeField>
[[nodiscard]] TileFunction choose_paths(const Kernel& kernel) {
  if constexpr (kGuided) {
    return kernel.count ? &render_tile<GuidedTracer<OneVolume<MakeField, Tally>>, true>
                        : &render_tile<GuidedTracer<OneVolume<MakeField, NoTally>>, false>;
  } else {
    if (kernel.paths == Paths::many_volumes) {
      return &render_tile<PathTracer<ManyVolumes<MakeField, Tally>>, true>;
    }
    return kernel.count ? &render_tile<PathTracer<OneVolume<MakeField, Tally>>, true>
                        : &render_tile<PathTracer<OneVolume<MakeField, NoTally>>, false>;
  }
}

/// For one way of look-up.
template <LookUp kLookUp, bool kGuided>
[[nodiscard]] TileFunction choose_kernel(const Kernel& kernel) {
  switch (kernel.micro_edge) {
    case 1:
      return choose_paths<kGuided, MakeSqueezed<kLookUp, 1>>(kernel);
    case 2:
      return choose_paths<kGuided, MakeSqueezed<kLookUp, 2>>(kernel);
    default:
      return choose_paths<kGuided, MakePlain<kLookUp>>(kernel);
  }
}

}  // namespace pvol::detail
