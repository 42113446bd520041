#include "render/light/emission/emission_setup.h"

#include <algorithm>

#include "pvol/volume/albedo_field.h"

namespace pvol::detail {

std::shared_ptr<const EmissionSetup> prepare_emission(std::span<const Volume> volumes,
                                                      const Scene& scene) {
  const RenderOptions& options = scene.options;
  EmissionSetup setup{.sources = emission_sources(volumes, options),
                      .points = options.emission_points};
  if (setup.sources.empty()) return nullptr;
  for (const Volume& v : volumes) {
    const auto its = std::ranges::find(setup.sources, v.fire.get(), &EmissionSource::fire);
    const bool burns = v.fire != nullptr && its != setup.sources.end();
    setup.at_collisions.push_back(burns ? its->at_collisions : nullptr);
  }
  const bool scatters =
      std::ranges::any_of(
          volumes,
          [](const Volume& v) { return !v.density.octree.empty() && largest_albedo(v) > 0; }) ||
      std::ranges::any_of(scene.surfaces, [](const Surface& s) {
        return max_component(material_of(s).albedo) > 0;
      });
  setup.lit = scatters && options.max_bounces != 0u;
  setup.sampled_in_volumes = setup.sampled_on_surfaces = setup.lit;
  if (setup.lit) setup.lights = EmissionLights(setup.sources);
  std::erase_if(setup.sources, [](const EmissionSource& s) { return s.lines().empty(); });
  std::vector<Box> boxes;
  for (const EmissionSource& s : setup.sources) boxes.push_back(s.box);
  setup.tree = BoxTree(boxes);
  return std::make_shared<const EmissionSetup>(std::move(setup));
}

}  // namespace pvol::detail
