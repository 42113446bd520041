// Based on: Arvo. Backward Ray Tracing. 1986 (light from the sources); Wagner, Haghighat. Automated
// Variance Reduction of Monte Carlo Shielding Calculations Using the Discrete Ordinates Adjoint
// Function. 1998 (importance from the other end). What is estimated here only steers paths.
#include "render/guide/photons.h"

#include <cmath>

#include "math/parallel.h"
#include "render/guide/light_counts.h"
#include "render/guide/photon_kernels.h"
#include "render/guide/photon_sources.h"
#include "render/path/camera_rays.h"
#include "render/path/gather_light.h"
#include "render/path/traversal.h"

namespace pvol::detail {
namespace {

template <class Traversal>
void trace(const PhotonSources& sources, const PathSetup& setup, const CoarseCells& cells,
           std::uint64_t number, LightCounts& counts) {
  Traversal traversal(setup);
  Rng rng(kPhotonKey, 0, number);
  if (setup.moving) traversal.work.set_time(sample_time(setup, 0, 0, std::uint32_t(number)));
  Photon p = sources.sample(rng);
  if (!traversal.start(p.ray)) return;
  Rgb power = p.power;
  if (!is_finite(power)) return;
  Vec3f d(p.ray.d);
  for (int flight = 0; flight < kMostPhotonFlights && !*setup.stop; ++flight) {
    const Hit hit = traversal.fly(d, rng);
    if (hit.component == nullptr) return;
    const std::uint32_t row = cells.row(traversal.place());
    counts.add(row, -d, luminance(power));
    if (flight == 0) counts.add_direct(row, p.source, luminance(power));
    power *= local(setup, traversal, *hit.component).albedo;
    if (!survives(power, kPhotonRoulette, rng)) return;
    d = sample_phase(hit.component->phase, d, rng);
  }
}

}  // namespace

IncidentLight trace_photons(const PathSetup& setup, const CoarseCells& cells, int photons) {
  const PhotonSources sources(setup, cells);
  IncidentLight light;
  light.axis = sources.axis();
  light.power = sources.power();
  if (!(light.power > 0) || !std::isfinite(light.power)) {
    light.power = 0;
    return light;
  }
  LightCounts counts(light, cells.count(), setup.light.sources.size(), photons);
  if (setup.kernel != KernelKind::scalar) {
    trace_photons_by_wavefront(setup, cells, sources, photons, counts);
  } else {
    const auto trace_one = setup.instances->moves() ? &trace<MovingVolumes>
                           : setup.is_one_still()   ? &trace<OneVolume>
                                                    : &trace<ManyVolumes>;
    parallel_for(0, std::size_t(photons), [&](std::size_t i) {
      if (!*setup.stop) trace_one(sources, setup, cells, i, counts);
    });
  }
  light.collided = counts.sums();
  light.direct = counts.direct();
  return light;
}

}  // namespace pvol::detail
