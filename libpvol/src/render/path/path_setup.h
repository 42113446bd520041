// What all paths of an image share, computed once a render.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pvol/render/film.h"
#include "pvol/render/lights.h"
#include "pvol/render/plan.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/phase.h"
#include "pvol/volume/volume.h"
#include "render/light/emission/emission_setup.h"
#include "render/light/open_sky.h"
#include "render/path/instances.h"
#include "render/scene/filter_offsets.h"
#include "render/scene/projection.h"
#include "render/scene/surface/surfaces.h"
#include "volume/dense_bounds.h"
#include "volume/flights.h"

namespace pvol::detail {

/// A part of an image, in pixels.
struct ImagePart {
  int x, y, width, height;
};

/// The one that is rendered. What is decided and prepared is that of the whole image, so that its
/// parts have the same pixels.
[[nodiscard]] inline ImagePart image_part(const RenderOptions& o) {
  return {o.crop_x, o.crop_y, o.crop_width ? o.crop_width : o.width - o.crop_x,
          o.crop_height ? o.crop_height : o.height - o.crop_y};
}

/// A component of a medium as a collision meets it.
struct MediumComponent {
  float share_up_to;  ///< of the extinction: its own and those of the components before it
  Rgb albedo;
  Rgb emitted;  ///< (1 - albedo) (L_e - constant): the source of a collision (THEORY.md, T5.1,
                ///< T5.5)
  PhaseFunction phase;
  Rgb source{0.0f};  ///< L_e - constant
};

/// What it is at a place, where its albedo is a field.
struct LocalMedium {
  Rgb albedo;
  Rgb emitted;  ///< as MediumComponent::emitted, with that albedo
};

/// Of a component that is the same everywhere.
[[nodiscard]] inline LocalMedium everywhere(const MediumComponent& m) {
  return {m.albedo, m.emitted};
}

/// Of a medium whose emission counts at collisions, or not at all there.
[[nodiscard]] inline std::vector<MediumComponent> make_components(const Medium& medium,
                                                                  Rgb constant, bool emits) {
  std::vector<MediumComponent> all;
  double sum = 0;
  for (const Component& c : medium.components) {
    sum += c.share;
    const Rgb source = (emits ? c.emission : Rgb(0.0f)) - constant;
    all.push_back({float(sum), c.albedo, (Rgb(1.0f) - c.albedo) * source, c.phase, source});
  }
  return all;
}

/// One of the volumes that paths walk through, at its first place.
struct VolumeSetup {
  const Volume& volume;
  Float4 cells_x, cells_y,
      cells_z;  // change of the position in cells per unit along each world axis
  Affine cells_to_world;
  std::vector<MediumComponent> components;
  Affine cells_to_albedo;  ///< to those of the albedo's field, where there is one

  /// Tested by rays before they enter the octree; none where a plan leaves it out.
  std::optional<RayShell> shell{};

  VolumeSetup(const Volume& v, Rgb constant, bool emits_at_collisions)
      : volume(v),
        cells_x(widen(Vec3f(v.density.world_to_cells.vector({1, 0, 0})))),
        cells_y(widen(Vec3f(v.density.world_to_cells.vector({0, 1, 0})))),
        cells_z(widen(Vec3f(v.density.world_to_cells.vector({0, 0, 1})))),
        cells_to_world(inverse(v.density.world_to_cells)),
        components(make_components(v.medium, constant, emits_at_collisions)),
        cells_to_albedo(v.albedo ? v.albedo->world_to_cells * cells_to_world : Affine{}) {}

  [[nodiscard]] Float4 in_cells(Vec3f direction) const {
    return cells_x * splat(direction.x) + cells_y * splat(direction.y) +
           cells_z * splat(direction.z);
  }

  /// A ray of the world in cells from the octree's origin; its t is world length still.
  [[nodiscard]] Ray in_cells(const Ray& ray) const {
    return {volume.density.world_to_cells.point(ray.o),
            volume.density.world_to_cells.vector(ray.d)};
  }

  /// The part of such a ray in the box of the support.
  [[nodiscard]] std::optional<Span> in_box(const Ray& cells) const {
    if (volume.density.octree.empty()) return std::nullopt;
    return intersect(volume.density.octree.support(), cells, 0,
                     std::numeric_limits<double>::infinity());
  }

  /// The component that a collision belongs to, in proportion to the shares.
  [[nodiscard]] const MediumComponent& choose_component(Rng& rng) const {
    if (components.size() == 1) return components.front();
    const float u = rng.uniform();
    for (const MediumComponent& m : components) {
      if (u < m.share_up_to) return m;
    }
    return components.back();
  }
};

class Importance;

[[nodiscard]] inline FieldKind field_kind(const Kernel& k) {
  return {.look_up = k.look_up,
          .micro_edge = k.mapped || k.moving ? 0 : k.micro_edge,
          .mapped = k.mapped,
          .moving = k.moving,
          .shared = k.shared};
}

struct PathSetup {
  std::span<const Volume> scene_volumes;  ///< those of the plan
  /// Radiance that is everywhere and is left out of sky, emission and paths, to be added to every
  /// camera path as it is (THEORY.md, T5.5); 0 where paths are not guided.
  Rgb constant;
  std::shared_ptr<const Importance> importance;  ///< of guided paths
  std::vector<VolumeSetup> volumes;
  std::shared_ptr<const Instances> instances;  ///< of the volumes
  Projection projection;
  FilterOffsets filter;
  Camera camera;
  std::shared_ptr<const Lighting> lighting;
  SkyLight sky;  ///< that of the lighting, as are the lights
  std::vector<LightSource> lights;
  float shadow_unit;  ///< radiance for which there is one shadow ray (THEORY.md, T5.2)
  std::uint32_t max_bounces;
  RenderOptions options;
  Flights flights;                                ///< of the plan's kernel
  bool count;                                     ///< whether they do
  bool first_collisions;                          ///< whether somebody asks where they are
  std::shared_ptr<const EmissionSetup> emission;  ///< along flights; null: there is none
  std::shared_ptr<const Surfaces> surfaces;       ///< null: there are none
  std::shared_ptr<const OpenSky> open_sky;        ///< where surfaces catch shadows
  /// Layers of light, each once: "sun_1", "sun_2", "point_1", a group's, "sky", "emission".
  std::vector<std::string> layer_names;
  /// Number of the layer of each light, of the sky and of emission.
  std::vector<std::size_t> layer_of;
  /// Once it is true, paths end as they please, and what they bring is to be dropped.
  const std::atomic<bool>* stop = &kNeverStop;
  KernelKind kernel;   ///< the kernel; not automatic
  bool moving;         ///< whether samples have times
  bool meets_lights;   ///< whether flights may pass lights
  bool albedo_varies;  ///< whether that of any volume is a field
  /// Of the one volume, where the kernel is one of lanes; setups may share them.
  std::shared_ptr<const DenseBounds> dense;

  PathSetup(const RenderPlan& plan, Rgb constant_ = Rgb(0.0f),
            std::shared_ptr<const DenseBounds> dense_ = nullptr)
      : scene_volumes(plan.volumes),
        constant(constant_),
        instances(std::make_shared<const Instances>(plan.volumes)),
        projection(plan.scene.camera, plan.scene.options.width, plan.scene.options.height),
        filter(plan.scene.options.filter, plan.scene.options.filter_width),
        camera(plan.scene.camera),
        lighting(plan.lighting ? plan.lighting
                               : std::make_shared<const Lighting>(make_lighting(plan.scene))),
        sky(lighting->sky),
        lights(make_light_sources(lighting->lights)),
        max_bounces(plan.scene.options.max_bounces.value_or(~0u)),
        options(plan.scene.options),
        flights(find_flights(field_kind(plan.kernel), plan.kernel.cancellable ? Monitoring::cancel
                                                      : plan.kernel.count     ? Monitoring::count
                                                                              : Monitoring::none)),
        count(plan.kernel.count),
        first_collisions(plan.scene.options.deep || of_first_collisions(plan.scene.options.aovs)),
        emission(plan.emission),
        surfaces(plan.surfaces),
        open_sky(surfaces && surfaces->catch_shadows() ? std::make_shared<const OpenSky>(sky)
                                                       : nullptr),
        kernel(plan.kernel.kind),
        moving(plan.kernel.moving || plan.kernel.places_move),
        meets_lights(any_is_met(lights)),
        albedo_varies(
            std::ranges::any_of(plan.volumes, [](const Volume& v) { return v.albedo != nullptr; })),
        dense(std::move(dense_)) {
    if (kernel != KernelKind::scalar && dense == nullptr) {
      dense = std::make_shared<const DenseBounds>(make_dense_bounds(plan.volumes.front().density));
    }
    std::vector<int> of_kind(std::variant_size_v<Light>);
    for (const Light& light : lighting->lights) {
      const int number = ++of_kind[light.index()];
      const std::string group = std::visit([](const auto& l) { return l.group; }, light);
      name_layer(group.empty() ? kind_name(light) + ('_' + std::to_string(number)) : group);
    }
    name_layer("sky");
    name_layer("emission");
    for (std::size_t i = 0; i < plan.volumes.size(); ++i) {
      const Volume& v = plan.volumes[i];
      volumes.emplace_back(v, constant, !gathers_along_flights(v, options));
      if (plan.shells[i].kept) volumes.back().shell.emplace(*v.shell, v.density.octree.origin);
    }
    const Box box = world_box(plan.volumes);
    constexpr float kUnit = 0.1f;  // of the light that falls on the volumes
    float light = sky.sampled() ? sky.mean_luminance() * 4 * float(std::numbers::pi) : 0;
    for (const LightSource& source : lights) {
      if (box.empty()) break;
      light += std::visit([&](const auto& l) { return luminance(l.irradiance_on(box)); }, source);
    }
    shadow_unit = kUnit * light;
  }

  /// Whether paths go through one volume alone, which stands still: in its cells.
  [[nodiscard]] bool is_one_still() const { return instances->is_one_still() && !surfaces; }

  /// Whether what is under way is to end. Asked at each collision and for each light: next to
  /// flights that costs nothing, and they may be long.
  [[nodiscard]] bool stopped() const { return stop->load(std::memory_order_relaxed); }

 private:
  /// Names the layer of the next light, which others may share.
  void name_layer(const std::string& name) {
    const auto at = std::find(layer_names.begin(), layer_names.end(), name);
    layer_of.push_back(std::size_t(at - layer_names.begin()));
    if (at == layer_names.end()) layer_names.push_back(name);
  }
};

}  // namespace pvol::detail
