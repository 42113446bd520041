// What fills the tiles of a film: the kernel that the plan chose, and its memory on each thread.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <vector>

#include "render/engine/wavefront/wavefront.h"

namespace pvol::detail {

class TileRenderer {
 public:
  /// For paths of the setup, guided where it has an importance. It outlives this.
  explicit TileRenderer(const PathSetup& setup);

  /// Adds samples to every pixel of a tile, a part of the film, up to its target, and their counts
  /// to `counts`, where the setup counts; from any thread. A pixel's samples are numbered from the
  /// film's first_sample on. Returns false, and leaves out what is under way, once the setup says
  /// stop. `tile` is no larger than edge().
  bool render(const ImagePart& tile, const SampleTargets& targets, Film& film, Counts& counts);

  /// Edge in pixels of the tiles for a pass over a film: kernels need many paths at once, and every
  /// thread its share.
  [[nodiscard]] int edge(const SampleTargets& targets, const Film& film, int threads) const;

 private:
  std::vector<WavefrontScene> scenes_;  ///< of the volumes
  WavefrontKernel kernel_;
  tbb::enumerable_thread_specific<WavefrontMemory> memory_;
};

}  // namespace pvol::detail
