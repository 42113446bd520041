#include "render/guide/photon_kernels.h"

#include "pvol/math/parallel.h"
#include "render/engine/wavefront/wavefront.h"

namespace pvol::detail {

void trace_photons_by_wavefront(const PathSetup& setup, const CoarseCells& cells,
                                const PhotonSources& sources, int photons, LightCounts& counts) {
  std::vector<WavefrontScene> scenes = make_wavefront_scenes(setup);
  for (WavefrontScene& s : scenes) s.count = false;
  const PhotonKernel kernel = find_photon_kernel(setup.kernel, scenes.front());
  constexpr std::size_t kBatch = 10'000;  // enough to keep lanes busy
  const std::size_t batches = (std::size_t(photons) + kBatch - 1) / kBatch;
  parallel_for(0, batches, [&](std::size_t i) {
    WavefrontMemory memory(setup);
    const std::uint64_t begin = i * kBatch;
    const std::uint64_t end = std::min(begin + kBatch, std::uint64_t(photons));
    kernel(scenes, memory, {cells, sources, begin, end, counts});
  });
}

}  // namespace pvol::detail
