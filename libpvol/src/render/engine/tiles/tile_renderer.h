// What fills the tiles of a film: the kernel that the plan chose, and its memory on each thread.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <vector>

#include "render/engine/tiles/render_tile.h"
#include "render/engine/wavefront/wavefront.h"

namespace pvol::detail {

class TileRenderer {
 public:
  /// For paths of the setup, guided where it has an importance. Both outlive this.
  TileRenderer(const RenderPlan& plan, const PathSetup& setup, Paths paths);

  /// As a TileFunction does it; from any thread. `tile` is no larger than edge().
  bool render(const ImagePart& tile, const SampleTargets& targets, Film& film, Counts& counts);

  /// Edge in pixels of the tiles for a pass over a film: kernels that follow many paths at once
  /// need many, and every thread its share.
  [[nodiscard]] int edge(const SampleTargets& targets, const Film& film, int threads) const;

 private:
  const PathSetup& setup_;
  TileFunction scalar_;
  std::vector<WavefrontScene> scenes_;  ///< of the volumes, where the kernel is one of lanes
  WavefrontKernel kernel_ = nullptr;
  tbb::enumerable_thread_specific<WavefrontMemory> memory_;
};

}  // namespace pvol::detail
