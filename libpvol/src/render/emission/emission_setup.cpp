#include "render/emission/emission_setup.h"

#include <algorithm>

#include "pvol/volume/facts.h"

namespace pvol::detail {

std::shared_ptr<const EmissionSetup> prepare_emission(std::span<const Volume> volumes,
                                                      const RenderOptions& options) {
  EmissionSetup setup{.sources = emission_sources(volumes, options),
                      .points = options.emission_points};
  if (setup.sources.empty()) return nullptr;
  Box matter;  // that scatters
  for (const Volume& v : volumes) {
    if (!v.density.octree.empty() && largest_albedo(v.medium) > 0) {
      matter = join(matter, v.density.world_box);
    }
  }
  setup.lit = !matter.empty() && options.max_bounces != 0u;
  if (setup.lit) {
    constexpr float kUnit = 0.1f;  // of what falls on the middle
    setup.lights = EmissionLights(setup.sources);
    setup.unit = kUnit * setup.lights.irradiance(matter.centre());
  }
  return std::make_shared<const EmissionSetup>(std::move(setup));
}

Rgb emission_along(const EmissionSetup& setup, const Ray& ray, double distance, Rng& rng) {
  Rgb sum(0.0f);
  for (const EmissionSource& source : setup.sources) {
    sum += integrate(source, ray, distance, rng.uniform(), setup.points);
  }
  return sum;
}

}  // namespace pvol::detail
