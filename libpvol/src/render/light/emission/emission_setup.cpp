#include "render/light/emission/emission_setup.h"

#include <algorithm>

#include "pvol/volume/albedo_field.h"

namespace pvol::detail {

LineSources::LineSources(std::vector<EmissionSource> all) : sources(std::move(all)) {
  std::vector<Box> boxes;
  for (const EmissionSource& s : sources) boxes.push_back(s.box);
  tree = BoxTree(boxes, 1);  // lines through what a ray misses would take long
}

std::shared_ptr<const EmissionSetup> prepare_emission(std::span<const Volume> volumes,
                                                      const Scene& scene) {
  const RenderOptions& options = scene.options;
  std::vector<EmissionSource> sources = emission_sources(volumes, options);
  if (sources.empty()) return nullptr;
  std::vector<std::shared_ptr<const FireAtCollisions>> at_collisions;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const auto its = std::ranges::find_if(sources, [&](const EmissionSource& s) {
      return s.volume == i && s.at_collisions != nullptr;
    });
    at_collisions.push_back(its != sources.end() ? its->at_collisions : nullptr);
  }
  const bool scatters =
      std::ranges::any_of(
          volumes,
          [](const Volume& v) { return !v.density.octree.empty() && largest_albedo(v) > 0; }) ||
      std::ranges::any_of(scene.surfaces, [](const Surface& s) {
        return max_component(material_of(s).albedo) > 0;
      });
  const bool lit = scatters && options.max_bounces != 0u;
  EmissionLights lights(lit ? sources : std::vector<EmissionSource>());
  std::erase_if(sources, [](const EmissionSource& s) { return s.lines().empty(); });
  return std::make_shared<const EmissionSetup>(
      EmissionSetup{.lines = LineSources(std::move(sources)),
                    .at_collisions = std::move(at_collisions),
                    .lit = lit,
                    .lights = std::move(lights),
                    .sampled_in_volumes = lit,
                    .sampled_on_surfaces = lit});
}

}  // namespace pvol::detail
