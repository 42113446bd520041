// A volume as paths walk through it.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "pvol/shell/ray_shell.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/phase.h"
#include "pvol/volume/volume.h"
#include "render/light/emission/fire_at_collisions.h"
#include "volume/flights.h"

namespace pvol::detail {

inline constexpr double kEndless = std::numeric_limits<double>::infinity();

/// A component of a medium as a collision meets it.
struct MediumComponent {
  float share_up_to;  ///< of the extinction: its own and those of the components before it
  Rgb albedo;
  Rgb emitted;  ///< (1 - albedo) (L_e - constant): the source of a collision (THEORY.md, T5.1,
                ///< T5.5)
  PhaseFunction phase;
  Rgb source{0.0f};  ///< L_e - constant
  double share = 1;  ///< of the extinction, its own
};

/// What a collision emits, whichever component it belongs to: the mean over them, so that one of a
/// small share that glows all the more is neither missed nor drawn with a large weight.
struct LocalMedium {
  Rgb albedo;
  Rgb emitted;  ///< as MediumComponent::emitted
};

/// Where albedos have the factor `color`.
[[nodiscard]] inline LocalMedium mean_of(const std::vector<MediumComponent>& components,
                                         Rgb color = Rgb(1.0f)) {
  Vec3d albedo, emitted;
  for (const MediumComponent& m : components) {
    const Rgb own = m.albedo * color;
    albedo += Vec3d(own) * m.share, emitted += Vec3d((Rgb(1.0f) - own) * m.source) * m.share;
  }
  return {Rgb(albedo), Rgb(emitted)};
}

/// Of a medium whose emission counts at collisions, or not at all there.
[[nodiscard]] inline std::vector<MediumComponent> make_components(const Medium& medium,
                                                                  Rgb constant, bool emits) {
  std::vector<MediumComponent> all;
  double sum = 0;
  for (const Component& c : medium.components) {
    sum += c.share;
    const Rgb source = (emits ? c.emission : Rgb(0.0f)) - constant;
    all.push_back(
        {float(sum), c.albedo, (Rgb(1.0f) - c.albedo) * source, c.phase, source, c.share});
  }
  return all;
}

/// One of the volumes that paths walk through, at its first place.
struct VolumeSetup {
  const Volume& volume;
  Affine cells_to_world;
  std::vector<MediumComponent> components;
  LocalMedium mean;              ///< of them, where the albedo is no field
  Affine cells_to_albedo;        ///< to those of the albedo's field, where there is one
  const FireAtCollisions* fire;  ///< whose light collisions bring; null: none
  Flights flights;               ///< through its field, one by one
  bool one_by_one;               ///< whether all flights through it are
  bool asks_lamps = false;       ///< whether flights do, all along (lamps_along.h)

  /// Tested by rays before they enter the octree; none where a plan leaves it out.
  std::optional<RayShell> shell{};

  VolumeSetup(const Volume& v, Rgb constant, bool emits_at_collisions,
              const FireAtCollisions* fire_, const Flights& flights_, bool one_by_one_)
      : volume(v),
        cells_to_world(inverse(v.density.world_to_cells)),
        components(make_components(v.medium, constant, emits_at_collisions)),
        mean(mean_of(components)),
        cells_to_albedo(v.albedo ? v.albedo->world_to_cells * cells_to_world : Affine{}),
        fire(fire_),
        flights(flights_),
        one_by_one(one_by_one_) {}

  /// A ray of the world in cells from the octree's origin; its t is world length still.
  [[nodiscard]] Ray in_cells(const Ray& ray) const {
    return {volume.density.world_to_cells.point(ray.o),
            volume.density.world_to_cells.vector(ray.d)};
  }

  /// The part of such a ray in the box of the support.
  [[nodiscard]] std::optional<Span> in_box(const Ray& cells) const {
    if (volume.density.octree.empty()) return std::nullopt;
    return intersect(volume.density.octree.support(), cells, 0, kEndless);
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

/// Where a flight collided.
struct CollisionPlace {
  const VolumeSetup* volume;
  Vec3d cells;  ///< of the volume
};

}  // namespace pvol::detail
