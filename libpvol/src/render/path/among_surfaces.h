// How paths move through volumes that have surfaces among them.
#pragma once

#include <algorithm>

#include "render/path/traversal.h"
#include "render/scene/surface/surfaces.h"

namespace pvol::detail {

/// Flights through volumes end where the first surface is; shadow rays end there for good. A path
/// may come back into volumes that it has left, so that places are those of the world.
///
/// Where scattered rays meet others than shadow rays do, a flight brings the light of lights, the
/// sky and fires from as far as shadow rays come, and scattered light by way of what scattered rays
/// meet. Where the first lies behind a surface that brings the second, one of them is drawn.
template <class Places>
class AmongSurfaces {
 public:
  static constexpr bool kByChannel = false, kHasSurfaces = true;

  explicit AmongSurfaces(const PathSetup& setup)
      : work(volumes_.work), volumes_(setup), surfaces_(*setup.surfaces) {}
  AmongSurfaces(const AmongSurfaces&) = delete;  // `work` is that of its volumes
  AmongSurfaces& operator=(const AmongSurfaces&) = delete;

  /// Aims along the camera's ray, whose direction is precise, and moves to where the first volume
  /// on it begins.
  void start(const Ray& ray) {
    ahead_ = surfaces_.camera->first_hit(ray, kEndless);
    direct_until_ = kEndless, scatters_ = true;
    const double first = volumes_.first_box(ray, ahead_.distance);
    any_volume_ = first != kEndless;
    if (!any_volume_) return;
    volumes_.move_to(ray.at(first));
    ahead_.distance -= first;
  }

  /// Aims from the path's place. What the flight brings is to be multiplied by the factor.
  [[nodiscard]] float aim(Vec3f direction, Rng& rng) {
    ahead_ = surfaces_.scattered->first_hit({position(), Vec3d(direction)}, kEndless);
    any_volume_ = true;
    return surfaces_.shadows_differ() ? aim_by_kind(direction, rng) : 1;
  }

  /// How far from the flight's start light is unscattered that the flight may bring.
  [[nodiscard]] double direct_until() const { return direct_until_; }
  /// Whether the path is scattered where the flight collides.
  [[nodiscard]] bool scatters() const { return scatters_; }

  /// Flies where it was aimed at: to a collision, else to the surface ahead, else it leaves.
  [[nodiscard]] Hit fly(Vec3f direction, Rng& rng) {
    if (any_volume_) {
      const Hit hit = volumes_.fly(direction, rng, ahead_.distance);
      if (hit.component != nullptr) return hit;
    }
    if (ahead_.material != nullptr) volumes_.move_to(ahead_.place);
    return {};
  }

  /// What a flight without a collision ended at; its finish is null where it left.
  [[nodiscard]] const SurfaceHit& surface() const { return ahead_; }

  // As of the volumes alone, with surfaces in the way.

  [[nodiscard]] FreeFlight free_flight(Vec3f direction, Rng& rng) {
    const SurfaceHit end = surfaces_.shadow->first_hit({position(), Vec3d(direction)}, kEndless);
    return volumes_.free_flight(direction, rng, end.distance);
  }
  [[nodiscard]] float transmittance(Vec3f direction, double distance, Rng& rng) {
    return volumes_.transmittance(direction, distance, rng);
  }
  /// Whether a surface is in the way of light from this distance, which `transmittance` does not
  /// ask.
  [[nodiscard]] bool hides(Vec3f direction, double distance) const {
    return surfaces_.hide({position(), Vec3d(direction)}, distance);
  }
  /// Whether a volume may dim light from this distance.
  [[nodiscard]] bool meets_volume(Vec3f direction, double distance) {
    return volumes_.meets_any(direction, distance);
  }
  [[nodiscard]] Vec3d position() const { return volumes_.position(); }
  [[nodiscard]] const WorldPlace& place() const { return volumes_.place(); }
  void return_to(const WorldPlace& place) { volumes_.return_to(place); }
  [[nodiscard]] CollisionPlace collision() const { return volumes_.collision(); }

  Work& work;

 private:
  VolumesAt<Places> volumes_;
  const Surfaces& surfaces_;
  SurfaceHit ahead_;
  bool any_volume_ = true;  // before that
  double direct_until_ = kEndless;
  bool scatters_ = true;

  [[nodiscard]] float aim_by_kind(Vec3f direction, Rng& rng) {
    direct_until_ = surfaces_.shadow->first_hit({position(), Vec3d(direction)}, kEndless).distance;
    scatters_ = true;
    if (ahead_.material == nullptr) return 1;
    if (ahead_.material->visible_shadow) direct_until_ = std::min(direct_until_, ahead_.distance);
    if (!(ahead_.distance < direct_until_)) return 1;
    // In proportion to the light on either way where that is about the same.
    const float weight = 1 + largest(ahead_.material->albedo);
    if (rng.uniform() * weight < 1) {
      ahead_ = {}, scatters_ = false;
      return weight;
    }
    direct_until_ = 0;
    return weight / (weight - 1);
  }
};

}  // namespace pvol::detail
