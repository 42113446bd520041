// Photons through the lane kernels.
#pragma once

#include "render/guide/light_counts.h"
#include "render/guide/photon_sources.h"

namespace pvol::detail {

/// Traces photons 0 to `photons` - 1 of the sources with the setup's kernel, and
/// adds them to the counts, which come out the same for any number of threads.
void trace_photons_by_wavefront(const PathSetup& setup, const CoarseCells& cells,
                                const PhotonSources& sources, int photons, LightCounts& counts);

}  // namespace pvol::detail
