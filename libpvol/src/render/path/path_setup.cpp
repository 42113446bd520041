#include "render/path/path_setup.h"

#include <algorithm>
#include <numbers>

#include "pvol/volume/facts.h"

namespace pvol::detail {
namespace {

[[nodiscard]] Monitoring monitoring_of(const Kernel& kernel) {
  if (kernel.cancellable) return Monitoring::cancel;
  return kernel.count ? Monitoring::count : Monitoring::none;
}

/// A share of the light that falls on the volumes.
[[nodiscard]] float shadow_unit_of(const SkyLight& sky, std::span<const LightSource> lights,
                                   const Box& box) {
  constexpr float kUnit = 0.1f;
  float light = sky.sampled() ? sky.mean_luminance() * 4 * float(std::numbers::pi) : 0;
  for (const LightSource& source : lights) {
    if (box.empty()) break;
    light += std::visit([&](const auto& l) { return luminance(l.irradiance_on(box)); }, source);
  }
  return kUnit * light;
}

/// Those of empty volumes have no words.
[[nodiscard]] std::vector<DenseBounds> bounds_of(std::span<const Volume> volumes) {
  std::vector<DenseBounds> all;
  for (const Volume& v : volumes) {
    all.push_back(v.density.octree.empty() ? DenseBounds{} : make_dense_bounds(v.density));
  }
  return all;
}

}  // namespace

CameraSetup::CameraSetup(const Scene& scene)
    : camera(scene.camera),
      projection(scene.camera, scene.options.width, scene.options.height),
      filter(scene.options.filter, scene.options.filter_width) {}

LightSetup::LightSetup(const RenderPlan& plan, const Box& box)
    : lighting(plan.lighting ? plan.lighting
                             : std::make_shared<const Lighting>(make_lighting(plan.scene))),
      sky(lighting->sky),
      sources(make_light_sources(lighting->lights)),
      shadow_unit(shadow_unit_of(sky, sources, box)),
      met_on_flights(any_is_met(sources)),
      open_sky(plan.surfaces && plan.surfaces->camera->catch_shadows()
                   ? std::make_shared<const OpenSky>(sky)
                   : nullptr) {}

LayerNames::LayerNames(const Lighting& lighting) {
  std::vector<int> of_kind(std::variant_size_v<Light>);
  for (const Light& light : lighting.lights) {
    const int number = ++of_kind[light.index()];
    const std::string group = std::visit([](const auto& l) { return l.group; }, light);
    add(group.empty() ? kind_name(light) + ('_' + std::to_string(number)) : group);
  }
  add("sky");
  add("emission");
}

void LayerNames::add(const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  of.push_back(std::size_t(at - names.begin()));
  if (at == names.end()) names.push_back(name);
}

PathSetup::PathSetup(const RenderPlan& plan, Rgb constant_,
                     std::shared_ptr<const std::vector<DenseBounds>> dense_)
    : scene_volumes(plan.volumes),
      options(plan.scene.options),
      view(plan.scene),
      light(plan, world_box(plan.volumes)),
      layers(*light.lighting),
      constant(constant_),
      instances(std::make_shared<const Instances>(plan.volumes)),
      emission(plan.emission),
      surfaces(plan.surfaces),
      flights(find_flights(field_kind(plan.kernel), monitoring_of(plan.kernel))),
      kernel(plan.kernel.kind),
      dense(std::move(dense_)),
      max_bounces(options.max_bounces.value_or(~0u)),
      count(plan.kernel.count),
      first_collisions(options.deep || of_first_collisions(options.aovs)),
      moving(plan.kernel.moving || plan.kernel.places_move),
      albedo_varies(
          std::ranges::any_of(plan.volumes, [](const Volume& v) { return v.albedo != nullptr; })),
      by_channel(std::ranges::any_of(plan.volumes,
                                     [](const Volume& v) { return is_chromatic(v.medium); })) {
  if (kernel != KernelKind::scalar && dense == nullptr) {
    dense = std::make_shared<const std::vector<DenseBounds>>(bounds_of(plan.volumes));
  }
  for (std::size_t i = 0; i < plan.volumes.size(); ++i) {
    const Volume& v = plan.volumes[i];
    const FireAtCollisions* fire = emission ? emission->at_collisions[i].get() : nullptr;
    volumes.emplace_back(v, constant, !gathers_along_flights(v, options), fire);
    if (plan.shells[i].kept) volumes.back().shell.emplace(*v.shell, v.density.octree.origin);
  }
}

}  // namespace pvol::detail
