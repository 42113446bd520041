// Based on: Arvo. Backward Ray Tracing. 1986 (light from the sources); Wagner, Haghighat. Automated
// Variance Reduction of Monte Carlo Shielding Calculations Using the Discrete Ordinates Adjoint
// Function. 1998 (importance from the other end). What is estimated here only steers paths.
#include "render/guide/photons.h"

#include <cmath>

#include "render/guide/light_counts.h"
#include "render/guide/photon_kernels.h"
#include "render/guide/photon_sources.h"

namespace pvol::detail {
IncidentLight trace_photons(const PathSetup& setup, const CoarseCells& cells, int photons) {
  const PhotonSources sources(setup, cells);
  IncidentLight light;
  light.axes = sources.axes();
  light.power = sources.power();
  if (!(light.power > 0) || !std::isfinite(light.power)) {
    light.power = 0;
    return light;
  }
  LightCounts counts(light, cells.count(), setup.light.sources.size(), photons);
  trace_photons_by_wavefront(setup, cells, sources, photons, counts);
  light.collided = counts.sums();
  light.direct = counts.direct();
  return light;
}

}  // namespace pvol::detail
