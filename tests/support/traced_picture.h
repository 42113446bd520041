// Pictures by the renderer's paths alone, of set-ups that a plan would not make.
#pragma once

#include <gtest/gtest.h>

#include "pvol/render/counts.h"
#include "pvol/render/film.h"
#include "pvol/render/options.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/path/path_setup.h"

namespace pvol::test {

/// A square picture, in passes of 50 samples, all in one tile.
[[nodiscard]] inline Film traced_picture(const detail::PathSetup& setup, const RenderOptions& o) {
  Film film;
  film.width = film.height = film.crop_width = film.crop_height = o.width;
  film.pixels.resize(std::size_t(film.width) * std::size_t(film.height));
  keep_exact_sums(film);
  Counts unused;
  detail::TileRenderer renderer(setup);
  for (std::uint32_t sample = 50; sample <= o.samples; sample += 50) {
    EXPECT_TRUE(renderer.render({0, 0, film.width, film.height}, {.all = sample}, film, unused));
  }
  return film;
}

}  // namespace pvol::test
