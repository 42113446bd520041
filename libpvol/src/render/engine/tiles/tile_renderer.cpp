#include "render/engine/tiles/tile_renderer.h"

namespace pvol::detail {

TileRenderer::TileRenderer(const PathSetup& setup)
    : scenes_(make_wavefront_scenes(setup)),
      kernel_(find_wavefront_kernel(setup.kernel, setup.importance != nullptr, scenes_.front())),
      memory_([&setup] { return WavefrontMemory(setup); }) {}

bool TileRenderer::render(const ImagePart& tile, const SampleTargets& targets, Film& film,
                          Counts& counts) {
  return kernel_(scenes_, memory_.local(), tile, targets, film, counts);
}

int TileRenderer::edge(const SampleTargets& targets, const Film& film, int threads) const {
  int edge = 16;
  constexpr std::int64_t kPaths = 8192;  // of a tile: its last ones leave lanes idle
  constexpr std::int64_t kTiles = 4;     // for each thread
  const std::int64_t pixels = std::int64_t(film.crop_width) * film.crop_height;
  std::int64_t samples = 1;  // the most of a pixel
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    samples = std::max(samples, std::int64_t(targets.of(i)) - film.pixels[i].samples);
  }
  while (4 * std::int64_t(edge) * edge * samples <= kPaths &&
         pixels >= kTiles * threads * 4 * edge * edge) {
    edge *= 2;
  }
  return edge;
}

}  // namespace pvol::detail
