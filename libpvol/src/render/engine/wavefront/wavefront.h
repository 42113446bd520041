// The kernels: many paths at once, in stages with queues between them, 16, 8 or 4 in a register.
#pragma once

#include "render/engine/tiles/sample_targets.h"
#include "render/engine/wavefront/wavefront_memory.h"
#include "render/engine/wavefront/wavefront_scene.h"
#include "render/guide/light_counts.h"
#include "render/guide/photon_sources.h"

namespace pvol::detail {

/// Adds samples to every pixel of a tile up to its target; they are at most kMostSlots. False where
/// the setup stopped it. Scenes are those of the volumes. Each sample's value is the same whatever
/// else is in the tile.
using WavefrontKernel = bool (*)(std::span<const WavefrontScene>, WavefrontMemory&,
                                 const ImagePart& tile, const SampleTargets&, Film&, Counts&);

/// For scenes like these.
[[nodiscard]] WavefrontKernel find_wavefront_kernel(KernelKind kernel, bool guided,
                                                    const WavefrontScene& scene);

/// Photons [begin, end) to trace and to count.
struct PhotonTask {
  const CoarseCells& cells;
  const PhotonSources& sources;
  std::uint64_t begin, end;
  LightCounts& counts;
};
using PhotonKernel = void (*)(std::span<const WavefrontScene>, WavefrontMemory&, const PhotonTask&);

[[nodiscard]] PhotonKernel find_photon_kernel(KernelKind kernel, const WavefrontScene& scene);

}  // namespace pvol::detail
