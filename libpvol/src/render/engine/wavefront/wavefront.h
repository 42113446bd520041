// The lane kernels: many paths at once, in stages with queues between them, 16 or 8 in a register.
// The scalar tracers (path/path_tracer.h, guide/guided_tracer.h) are their reference.
#pragma once

#include "render/engine/tiles/sample_targets.h"
#include "render/engine/wavefront/lane_memory.h"
#include "render/engine/wavefront/lane_scene.h"
#include "render/guide/light_counts.h"
#include "render/guide/photon_sources.h"

namespace pvol::detail {

/// Adds samples to every pixel of a tile, as a TileFunction does; they are at most kMostSlots. Each
/// sample's value is the same whatever else is in the tile.
using LaneKernel = bool (*)(const LaneScene&, LaneMemory&, const ImagePart& tile,
                            const SampleTargets&, Film&, Counts&);

[[nodiscard]] LaneKernel find_lane_kernel(KernelKind lanes, bool guided, bool one_lobe);

/// Photons [begin, end) to trace and to count.
struct PhotonTask {
  const CoarseCells& cells;
  const PhotonSources& sources;
  std::uint64_t begin, end;
  LightCounts& counts;
};
using PhotonKernel = void (*)(const LaneScene&, LaneMemory&, const PhotonTask&);

[[nodiscard]] PhotonKernel find_photon_kernel(KernelKind lanes, bool one_lobe);

}  // namespace pvol::detail
