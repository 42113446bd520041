// One camera path: free flights, emission, next-event estimation, scattering.
#pragma once

#include "render/path/camera_rays.h"
#include "render/path/gather_light.h"
#include "render/path/path_kind.h"
#include "render/path/traversal.h"

namespace pvol::detail {

/// Traces paths of a kind through what `Traversal` makes of the scene's volumes. Both are chosen
/// once a scene, not once a collision.
template <class Traversal, class Kind = AnyPaths>
class PathTracer {
 public:
  explicit PathTracer(const PathSetup& setup) : traversal(setup), s_(setup), r_(setup) {}

  /// Compiled into one function, but for flights and shadow rays: the cost of a path does not hang
  /// on how a compiler weighs many small ones.
  [[nodiscard, gnu::flatten]] const PathResult& trace(int x, int y, std::uint32_t sample) {
    r_.reset();
    auto [rng, ray] = CameraSample(s_, x, y, sample);
    direction_ = Vec3f(ray.d);
    if (!Kind::kSimple && s_.moving) {
      r_.time = sample_time(s_, x, y, sample);
      traversal.work.set_time(r_.time);
    }
    if (traversal.start(ray)) {
      walk(ray.o, rng);
    } else {
      if (s_.options.background) add_seen(s_, direction_, Rgb(1.0f), r_);
      if (flights_bring_light()) add_on_the_way(ray.o, false, 0, Rgb(1.0f), rng);
      r_.scattered(0);
    }
    return r_;
  }

  static constexpr bool kHasSurfaces = false;
  Traversal traversal;
  std::uint64_t collisions = 0, shadow_rays = 0;

 private:
  const PathSetup& s_;
  PathResult r_;
  Vec3f direction_;                             // of the flight, in the world
  Vec3f from_;                                  // before the last scattering
  const MediumComponent* component_ = nullptr;  // of the last scattering

  /// Whether flights bring light besides that of their ends.
  [[nodiscard]] bool flights_bring_light() const {
    return !Kind::kSimple && s_.flights_bring_light();
  }
  /// Whether what emits along flights is a light.
  [[nodiscard]] bool samples_fires() const {
    return !Kind::kSimple && s_.samples_fires();
  }

  /// From the camera's place.
  void walk(Vec3d from, Rng& rng) {
    Rgb throughput(1.0f);
    for (std::uint32_t bounces = 0;; ++bounces) {
      if (flights_bring_light() && bounces > 0) from = traversal.position();
      const auto hit = fly(throughput, rng);
      throughput *= hit.weight;
      if (flights_bring_light())
        add_on_the_way(from, hit.component != nullptr, bounces, throughput, rng);
      if (hit.component == nullptr) {
        if (bounces > 0) {
          const auto pdf = [&] { return pdf_phase(Kind::phase(*component_), from_, direction_); };
          add_scattered(s_, pdf, direction_, throughput, r_);
        } else {
          r_.alpha = 1 - mean_of(hit.weight);
          if constexpr (Traversal::kByChannel) r_.tint = hit.weight - Rgb(mean_of(hit.weight));
          if (s_.options.background) add_seen(s_, direction_, throughput, r_);
        }
        r_.scattered(bounces);
        return;
      }
      if (bounces == 0) {
        r_.alpha = 1;
        if (s_.first_collisions)
          r_.first = traversal.position(), r_.first_weight = mean_of(hit.weight);
      }
      ++collisions;
      if (s_.stopped()) return;
      const MediumComponent& component = *hit.component;
      const auto& here = Kind::local(s_, traversal, component);
      add_emitted(s_, here, throughput, r_);
      r_.scattered(bounces);
      if (bounces == s_.max_bounces) return;
      throughput *= here.albedo;
      if (!survives(throughput, rng)) return;
      component_ = &component;
      const auto& phase = Kind::phase(component);
      const auto importance = [](std::size_t) { return 1.0f; };
      const PathVertex<Traversal> vertex{s_,  traversal,   direction_, throughput,
                                         rng, shadow_rays, r_};
      add_light_here<Kind>(vertex, phase, importance);
      if (samples_fires()) add_fire_here(vertex, component.phase);
      r_.scattered(bounces + 1);
      from_ = direction_;
      direction_ = sample_phase(phase, from_, rng);
    }
  }

  /// The next flight of a path of this throughput.
  [[nodiscard]] auto fly(Rgb throughput, Rng& rng) {
    if constexpr (Traversal::kByChannel) {
      return traversal.fly(direction_, throughput, rng);
    } else {
      return traversal.fly(direction_, rng);
    }
  }

  [[nodiscard]] static float mean_of(float weight) { return weight; }
  [[nodiscard]] static float mean_of(Rgb weight) { return (weight.x + weight.y + weight.z) / 3; }

  /// What a flight brings on its way.
  void add_on_the_way(Vec3d from, bool collided, std::uint32_t bounces, Rgb throughput, Rng& rng) {
    const auto pdf = [&] {
      return bounces > 0 ? pdf_phase(component_->phase, from_, direction_) : 0.0f;
    };
    const double length = collided ? pvol::length(traversal.position() - from) : kEndless;
    const CollisionPlace end = collided && s_.emission ? traversal.collision() : CollisionPlace{};
    detail::add_on_the_way(s_, {from, direction_, length, end}, pdf, throughput, rng, r_);
  }
};

}  // namespace pvol::detail
