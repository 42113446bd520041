// One camera path through volumes and off surfaces.
#pragma once

#include "render/guide/branches.h"
#include "render/guide/turn_by_importance.h"
#include "render/path/among_surfaces.h"
#include "render/path/camera_rays.h"
#include "render/path/gather_light.h"
#include "render/path/lambert.h"
#include "render/path/open_light.h"
#include "render/path/path_kind.h"

namespace pvol::detail {

/// Traces paths of any kind through volumes and off surfaces; none of it is in the way of scenes
/// without surfaces. Where there is an importance, paths end, split and turn in volumes by it, as
/// guided ones do; surfaces have none.
template <class Places>
class SurfaceTracer {
 public:
  explicit SurfaceTracer(const PathSetup& setup)
      : traversal(setup), s_(setup), r_(setup), direct_(setup) {}

  [[nodiscard]] const PathResult& trace(int x, int y, std::uint32_t sample) {
    auto [rng, ray] = CameraSample(s_, x, y, sample);
    start(ray, x, y, sample);
    for (Vec3d from = ray.o;; from = traversal.position()) {
      const Hit hit = traversal.fly(direction_, rng);
      const SurfaceHit& surface = traversal.surface();
      const bool leaves = hit.component == nullptr && surface.material == nullptr;
      if (s_.flights_bring_light()) add_on_the_way(from, hit, !leaves, rng);
      const bool goes_on =
          hit.component ? collide(*hit.component, from, rng) : !leaves && meet(surface, rng);
      if (leaves) leave();
      if (!goes_on && !resume(rng)) return r_;
      flight_weight_ = traversal.aim(direction_, rng);
      throughput_ *= flight_weight_;
    }
  }

  static constexpr bool kHasSurfaces = true;
  AmongSurfaces<Places> traversal;
  std::uint64_t collisions = 0, shadow_rays = 0, surface_hits = 0;

 private:
  const PathSetup& s_;
  PathResult r_, direct_;   // of the path; of what arrives at a shadow catcher unscattered
  Vec3f direction_, from_;  // of the flight, and of the one before it
  Rgb throughput_;
  float flight_weight_ = 1;  // a part of that, of the flight alone
  std::uint32_t scatterings_ = 0;
  // Of the last collision; null where a surface came after it.
  const MediumComponent* component_ = nullptr;
  Lambert lobe_;             // of that surface
  bool on_catcher_ = false;  // whether that was a shadow catcher before the camera

  void start(const Ray& ray, int x, int y, std::uint32_t sample) {
    r_.reset();
    direction_ = Vec3f(ray.d);
    throughput_ = Rgb(1.0f);
    flight_weight_ = 1;
    scatterings_ = 0;
    on_catcher_ = false;
    if (s_.moving) {
      r_.time = sample_time(s_, x, y, sample);
      traversal.work.set_time(r_.time);
    }
    traversal.start(ray);
  }

  /// Of the direction of the flight, as the last scattering drew it; 0 before the first.
  [[nodiscard]] float pdf() const {
    if (scatterings_ == 0) return 0;
    return component_ ? pdf_phase(component_->phase, from_, direction_)
                      : pdf_phase(lobe_, from_, direction_);
  }

  /// What a flight brings on its way. Light on a shadow catcher is there without the shadow, too.
  void add_on_the_way(Vec3d from, const Hit& hit, bool ends, Rng& rng) {
    const auto own = [&] { return pdf(); };
    FlightLine flight{from, direction_, ends ? length(traversal.position() - from) : kEndless};
    if (flight.length > traversal.direct_until()) {
      flight.length = traversal.direct_until();
    } else if (hit.component && s_.emission) {
      flight.end = traversal.collision();
    }
    if (s_.emission) {
      const auto sampled = [&] { return samples_fires() ? pdf() : 0.0f; };
      add_along(s_, flight, sampled, throughput_, rng, r_);
      r_.scattered(scatterings_);
    }
    if (!s_.light.met_on_flights) return;
    // A lamp on the surface that ends the flight is met before it.
    flight.length += 2 * traversal.surface().clearance + 1e-6 * flight.length;
    if (on_catcher_) {
      direct_.reset();
      add_met(s_, flight, own, Rgb(flight_weight_), direct_);
      subtract_direct_light();
    } else {
      add_met(s_, flight, own, throughput_, r_);
    }
  }

  /// Whether fires are sampled as lights where the path is scattered.
  [[nodiscard]] bool samples_fires() const {
    return s_.emission &&
           (component_ ? s_.emission->sampled_in_volumes : s_.emission->sampled_on_surfaces);
  }

  void leave() {
    if (traversal.direct_until() != kEndless) return;
    if (scatterings_ == 0) {
      if (s_.options.background) {
        add_constant(s_, r_);
        add_seen(s_, direction_, throughput_, r_);
      }
    } else if (on_catcher_) {
      const auto own = [&] { return pdf(); };
      direct_.reset();
      add_scattered(s_, own, direction_, Rgb(flight_weight_), direct_);
      return subtract_direct_light();
    } else {
      add_scattered(
          s_, [&] { return pdf(); }, direction_, throughput_, r_);
    }
    r_.scattered(scatterings_);
  }

  /// A collision of a flight from there; whether the path goes on.
  [[nodiscard]] bool collide(const MediumComponent& component, Vec3d from, Rng& rng) {
    on_catcher_ = false;
    const Vec3d place = traversal.position();
    if (scatterings_ == 0) note_first(place);
    ++collisions;
    const auto& here = detail::local(s_, traversal, component);
    if (traversal.direct_until() == kEndless || length(place - from) < traversal.direct_until())
      add_emitted(s_, here, throughput_, r_);
    r_.scattered(scatterings_);
    component_ = &component;
    if (!traversal.scatters() || is_at_end()) return false;
    if (!s_.importance) {
      throughput_ *= here.albedo;
      if (!survives(throughput_, rng)) return false;
      gather(component.phase, even_importance, rng);
      turn_path(component.phase, rng);
      return true;
    }
    const Importance& importance = *s_.importance;
    const Importance::Row& row = importance.row(traversal.place());
    const float contribution = largest(throughput_) * row.of(importance.half_sine(direction_));
    if (!survives_by_contribution(contribution, throughput_, rng)) return false;
    throughput_ *= here.albedo;
    if (!(largest(throughput_) > 0)) return false;
    const float* importances = importance.shadow_importance(row);
    const auto importance_of = [&](std::size_t light) { return importances[light]; };
    gather(component.phase, importance_of, rng);
    if (contribution > kSplitAbove && !waiting_.full()) {
      const int copies = int(std::min(contribution, kMostCopies));
      throughput_ *= 1 / float(copies);
      waiting_.add(
          {traversal.place(), component_, &row, direction_, throughput_, scatterings_, copies - 1});
    }
    turn_guided(row, rng);
    return true;
  }

  /// Scatters by importance.
  void turn_guided(const Importance::Row& row, Rng& rng) {
    from_ = direction_;
    direction_ = turn_by_importance<AnyPaths>(*s_.importance, row, component_->phase, from_,
                                              throughput_, rng);
  }

  /// Goes on with a branch that waits; false where none does.
  [[nodiscard]] bool resume(Rng& rng) {
    const Branch<WorldPlace>* branch = waiting_.take();
    if (branch == nullptr) return false;
    traversal.return_to(branch->place);
    component_ = branch->component;
    direction_ = branch->direction;
    throughput_ = branch->throughput;
    scatterings_ = branch->scatterings;
    on_catcher_ = false;
    turn_guided(*branch->row, rng);
    return true;
  }

  /// A surface; whether the path goes on.
  [[nodiscard]] bool meet(const SurfaceHit& surface, Rng& rng) {
    const Material& material = *surface.material;
    r_.scattered(scatterings_);
    ++surface_hits;
    component_ = nullptr;
    lobe_.normal = Vec3f(surface.normal);
    on_catcher_ = false;
    if (scatterings_ == 0) {
      if (material.visibility == Visibility::holdout) return false;
      if (material.visibility == Visibility::shadow_catcher) return catch_shadow(surface, rng);
      note_first(surface.place);
      r_.first_normal = surface.normal;
      r_.first_material = &material;
    }
    subtract_absorbed(s_, material.albedo, throughput_, r_);
    if (is_at_end()) return false;
    throughput_ *= material.albedo;
    const bool seen = scatterings_ == 0;  // it is its pixel's noise, and no roulette decides on it
    if (seen ? !(largest(throughput_) > 0) : !survives(throughput_, rng)) return false;
    gather(lobe_, even_importance, rng);
    turn_path(lobe_, rng);
    return true;
  }

  /// Makes the sample one that met something.
  void note_first(Vec3d place) {
    r_.alpha = 1;
    add_constant(s_, r_);
    if (s_.first_collisions) r_.first = place, r_.first_weight = 1;
  }

  [[nodiscard]] bool is_at_end() const { return s_.stopped() || scatterings_ >= s_.max_bounces; }

  [[nodiscard]] static float even_importance(std::size_t /*light*/) { return 1; }

  /// Light that a lobe scatters into the path: one more scattering.
  template <class Lobe, class ShadowImportance>
  void gather(const Lobe& lobe, const ShadowImportance& importance, Rng& rng) {
    const auto here = vertex(throughput_, rng, r_);
    add_light_here<AnyPaths>(here, lobe, importance);
    if (samples_fires()) add_fire_here(here, lobe);
    r_.scattered(++scatterings_);
  }

  [[nodiscard]] PathVertex<AmongSurfaces<Places>> vertex(Rgb throughput, Rng& rng, PathResult& r) {
    const bool on_surface = component_ == nullptr;
    return {s_,         traversal,  direction_,
            throughput, rng,        shadow_rays,
            r,          on_surface, on_surface && scatterings_ == 0};
  }

  template <class Lobe>
  void turn_path(const Lobe& lobe, Rng& rng) {
    from_ = direction_;
    direction_ = sample_phase(lobe, from_, rng);
  }

  // A shadow catcher covers what lies behind it by as much of the light as does not reach it
  // unscattered, and adds the light that reaches it otherwise (THEORY.md, T5.18).

  /// Goes on from there, for the light that is met and, if bounces allow, for what is scattered.
  [[nodiscard]] bool catch_shadow(const SurfaceHit& surface, Rng& rng) {
    if (s_.stopped()) return false;
    on_catcher_ = true;
    r_.first = surface.place, r_.first_material = surface.material;
    seen_ = direction_;
    open_light_ = open_(s_.light, surface);
    r_.alpha = 1;
    if (largest(open_light_) > 0) {
      direct_.reset();
      add_light_here<AnyPaths>(vertex(Rgb(1.0f), rng, direct_), lobe_, even_importance);
    }
    subtract_direct_light();
    throughput_ = s_.max_bounces > 0 ? surface.material->albedo : Rgb(0.0f);
    if (samples_fires() && largest(throughput_) > 0) {
      add_fire_here(vertex(throughput_, rng, r_), lobe_);
    }
    r_.scattered(++scatterings_);
    turn_path(lobe_, rng);
    return largest(throughput_) > 0 || largest(open_light_) > 0;
  }

  /// Takes what arrived unscattered off what the catcher covers; where nothing ever does, there is
  /// no shadow, and it covers nothing.
  void subtract_direct_light() {
    Rgb shares(1.0f);
    if (const float open = luminance(open_light_); open > 0) {
      const float share = luminance(direct_.radiance) / open;
      shares = Rgb(share);
      for (int c = 0; c < 3; ++c) {
        if (open_light_[c] > 0) shares[c] = direct_.radiance[c] / open_light_[c];
      }
      r_.alpha -= share;
      r_.tint += shares - Rgb(share);
    } else {
      if (r_.alpha == 0) return;
      r_.alpha = 0;
    }
    if (s_.options.background) {
      const Rgb before = r_.radiance;
      add_seen(s_, seen_, shares, r_);
      r_.background += r_.radiance - before;
    }
    r_.scattered(0);
  }

  Branches<WorldPlace> waiting_;
  Vec3f seen_;      // the camera's direction to the catcher
  Rgb open_light_;  // there without shadow
  OpenLight open_;
};

}  // namespace pvol::detail
