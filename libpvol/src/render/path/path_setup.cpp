#include "render/path/path_setup.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <unordered_map>

#include "pvol/volume/facts.h"
#include "render/scene/small_picture.h"
#include "volume/simd/choose_batch_kernels.h"

namespace pvol::detail {
namespace {

/// Most lights that are all asked at a collision, and on a surface.
constexpr std::size_t kMostInVolumes = 64, kMostOnSurfaces = 16;

[[nodiscard]] std::vector<std::uint32_t> numbers_of_suns(std::span<const LightSource> lights) {
  std::vector<std::uint32_t> suns;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (std::holds_alternative<SunLight>(lights[i])) suns.push_back(std::uint32_t(i));
  }
  return suns;
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

/// Luminance from which on a sky counts as a light that is seen. Below about twice the radiance of
/// the clouds before it, what is seen only of rays that pass varies less (THEORY.md, T5.26).
[[nodiscard]] float bright_sky_of(const SkyLight& sky) {
  constexpr float kBright = 8;
  const float bright = kBright * sky.mean_luminance();
  return sky.largest_luminance() > bright ? bright : std::numeric_limits<float>::infinity();
}

/// Numbers of lights that a ray of the camera may meet: on its way, or behind all.
[[nodiscard]] std::vector<std::uint32_t> find_seen(std::span<const Light> lights,
                                                   std::span<const LightSource> sources, bool sky) {
  std::vector<std::uint32_t> seen;
  for (std::uint32_t i = 0; i < lights.size(); ++i) {
    const auto* const sun = std::get_if<SunLight>(&sources[i]);
    if (sun != nullptr ? sun->disc_pdf > 0 : camera_meets(lights[i])) seen.push_back(i);
  }
  if (sky) seen.push_back(std::uint32_t(lights.size()));
  return seen;
}

/// Lines towards those lights: none in deep pictures, whose samples have nothing of what is behind
/// them, nor where it would take many points in a cell to tell depths (THEORY.md, T5.26).
[[nodiscard]] std::shared_ptr<const LineSources> prepare_depths(const RenderPlan& plan) {
  constexpr int kMostPoints = 4 * kLeafEdge;
  if (plan.scene.options.deep) return nullptr;
  std::vector<EmissionSource> all = depth_sources(plan.volumes);
  const auto takes_many = [](const EmissionSource& s) { return s.points > kMostPoints; };
  if (std::ranges::any_of(all, takes_many)) return nullptr;
  return std::make_shared<const LineSources>(std::move(all));
}

[[nodiscard]] bool is_one_by_one(const RenderPlan& plan, std::size_t volume) {
  return !plan.one_by_one.empty() && plan.one_by_one[volume] != nullptr;
}

[[nodiscard]] std::vector<DenseBounds> bounds_of(const RenderPlan& plan) {
  std::vector<DenseBounds> all(plan.volumes.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const VolumeField& f = plan.volumes[i].density;
    if (!f.octree.empty() && !is_one_by_one(plan, i)) all[i] = make_dense_bounds(f);
  }
  return all;
}

}  // namespace

CameraSetup::CameraSetup(const Scene& scene)
    : camera(scene.camera),
      projection(middle_camera(camera), scene.options.width, scene.options.height),
      filter(scene.options.filter, scene.options.filter_width) {
  const auto map = motion_of(camera);
  const Shutter& shutter = camera.shutter;
  if (!map || shutter.open == shutter.close) return;
  motion = {*map, inverse(map->at(shutter.at(0.5)))};
}

LightSetup::LightSetup(const RenderPlan& plan, const Box& box)
    : lighting(plan.lighting ? plan.lighting
                             : std::make_shared<const Lighting>(make_lighting(plan.scene))),
      sky(lighting->sky),
      sources(make_light_sources(lighting->lights)),
      suns(numbers_of_suns(sources)),
      many(std::make_shared<const ManyLights>(lighting->lights)),
      drawn_in_volumes(sources.size() > kMostInVolumes),
      drawn_on_surfaces(sources.size() > kMostOnSurfaces),
      shadow_unit(shadow_unit_of(sky, sources, box)),
      met(sources),
      bright_sky(bright_sky_of(sky)),
      seen(find_seen(lighting->lights, sources, std::isfinite(bright_sky))),
      open_sky(plan.surfaces && plan.surfaces->camera->catch_shadows()
                   ? std::make_shared<const OpenSky>(sky)
                   : nullptr) {}

LayerNames::LayerNames(const Lighting& lighting) {
  std::vector<int> of_kind(std::variant_size_v<Light>);
  std::unordered_map<std::string, std::size_t> number_of;
  const auto add = [&](const std::string& name) {
    const auto [at, is_new] = number_of.try_emplace(name, names.size());
    of.push_back(at->second);
    if (is_new) names.push_back(name);
  };
  for (const Light& light : lighting.lights) {
    const int number = ++of_kind[light.index()];
    const std::string group = std::visit([](const auto& l) { return l.group; }, light);
    add(group.empty() ? kind_name(light) + ('_' + std::to_string(number)) : group);
  }
  add("sky");
  add("emission");
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
      objects(options.aovs.has(Aov::objects)
                  ? std::make_shared<const SceneObjects>(plan.scene, *instances)
                  : nullptr),
      kernel(lanes_for(plan.kernel.kind)),
      dense(std::move(dense_)),
      max_bounces(options.max_bounces.value_or(~0u)),
      count(plan.kernel.count),
      halves(options.aovs.has(Aov::halves)),
      first_collisions(options.deep || of_first_collisions(options.aovs)),
      moving(plan.kernel.moving || plan.kernel.places_move),
      albedo_varies(
          std::ranges::any_of(plan.volumes, [](const Volume& v) { return v.albedo != nullptr; })),
      by_channel(std::ranges::any_of(plan.volumes,
                                     [](const Volume& v) { return is_chromatic(v.medium); })),
      weighs(by_channel || is_weighted(options.tracker)) {
  if (dense == nullptr) dense = std::make_shared<const std::vector<DenseBounds>>(bounds_of(plan));
  for (std::size_t i = 0; i < plan.volumes.size(); ++i) {
    const Volume& v = plan.volumes[i];
    const FireAtCollisions* fire = emission ? emission->at_collisions[i].get() : nullptr;
    volumes.emplace_back(v, constant, !gathers_along_flights(v, options), fire,
                         find_flights(kind_of(v.density)), is_one_by_one(plan, i));
    volumes.back().asks_lamps = i < plan.line_lamps.size() && plan.line_lamps[i];
    if (plan.shells[i].kept) volumes.back().shell.emplace(*v.shell, v.density.octree.origin);
  }
  if (std::ranges::any_of(volumes, &VolumeSetup::asks_lamps)) {
    std::ranges::transform(light.sources, std::back_inserter(lamps), lamp_of);
  }
  if (!light.seen.empty()) depths = prepare_depths(plan);
  // Of records without weights, and whose ways bring nothing.
  const bool may_be_thin = !weighs && !flights_bring_light() && lamps.empty();
  free_radii = FreeRadii(volumes, *instances, surfaces.get(), may_be_thin);
}

PathSetup PathSetup::in_small(int pixels) const {
  Scene scene;
  scene.camera = view.camera;
  scene.options = detail::in_small(options, pixels);
  PathSetup small = *this;
  small.options = scene.options;
  small.view = CameraSetup(scene);
  return small;
}

}  // namespace pvol::detail
