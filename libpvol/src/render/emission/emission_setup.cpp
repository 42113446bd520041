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
    if (v.density.octree.empty() || !(largest_albedo(v.medium) > 0)) continue;
    for (std::size_t i = 0; i < count_places(v); ++i) {
      matter = join(matter, world_box(v.density, v, i));
    }
  }
  std::vector<Box> boxes;
  for (const EmissionSource& s : setup.sources) boxes.push_back(s.box);
  setup.tree = BoxTree(boxes);
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
  const float u = rng.uniform();  // for all: each is right on average, and so is the sum
  setup.tree.visit(ray, distance, [&](std::uint32_t i, double limit) {
    sum += integrate(setup.sources[i], ray, distance, u, setup.points);
    return limit;
  });
  return sum;
}

}  // namespace pvol::detail
