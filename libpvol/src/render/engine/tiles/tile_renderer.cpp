#include "render/engine/tiles/tile_renderer.h"

namespace pvol::detail {

TileRenderer::TileRenderer(const RenderPlan& plan, const PathSetup& setup, Paths paths)
    : setup_(setup),
      scalar_(find_tile_function(paths, setup)),
      memory_([&setup] { return WavefrontMemory(setup); }) {
  if (plan.kernel.kind == KernelKind::scalar) return;
  scenes_ = make_wavefront_scenes(setup);
  kernel_ = find_wavefront_kernel(plan.kernel.kind, setup.importance != nullptr, scenes_.front());
}

bool TileRenderer::render(const ImagePart& tile, const SampleTargets& targets, Film& film,
                          Counts& counts) {
  if (kernel_ == nullptr) return scalar_(setup_, tile, targets, film, counts);
  return kernel_(scenes_, memory_.local(), tile, targets, film, counts);
}

int TileRenderer::edge(const SampleTargets& targets, const Film& film, int threads) const {
  int edge = 16;
  if (kernel_ == nullptr) return edge;
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
