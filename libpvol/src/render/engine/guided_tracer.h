// One camera path and its branches, guided by importance.
#pragma once

#include <type_traits>
#include <utility>

#include "render/engine/path_tracer.h"
#include "render/guide/branches.h"
#include "render/guide/turn_by_importance.h"

namespace pvol::detail {

/// Traces paths that end, split and turn by their importance, for a tracker without weights
/// (THEORY.md, T5.5). The picture is that of the plain tracer on average.
/// Based on: Vorba, Krivanek. Adjoint-Driven Russian Roulette and Splitting. 2016.
template <class Traversal, class Kind = AnyPaths>
class GuidedTracer {
 public:
  explicit GuidedTracer(const PathSetup& setup)
      : traversal(setup), s_(setup), importance_(*setup.importance), r_(setup) {}

  /// In one function, like PathTracer::trace.
  [[nodiscard, gnu::flatten]] const PathResult& trace(int x, int y, std::uint32_t sample) {
    r_.reset();
    auto [rng, ray] = CameraSample(s_, x, y, sample);
    direction_ = Vec3f(ray.d);
    if (!Kind::kSimple && s_.moving) {
      r_.time = sample_time(s_, x, y, sample);
      traversal.work.set_time(r_.time);
    }
    const Hit first = traversal.start(ray) ? traversal.fly(direction_, rng) : Hit{};
    const auto unscattered = [] { return 0.0f; };
    if (flights_bring_light()) add_on_the_way(ray.o, first, unscattered, Rgb(1.0f), rng);
    if (first.component == nullptr) {
      if (s_.options.background) {
        add_constant(s_, r_);
        add_seen(s_, direction_, Rgb(1.0f), r_);
      }
      r_.scattered(0);
      return r_;
    }
    add_constant(s_, r_);
    r_.alpha = 1;
    if (s_.first_collisions) r_.first = traversal.position(), r_.first_weight = 1;
    throughput_ = Rgb(1.0f);
    scatterings_ = 0;
    bool alive = collide(*first.component, rng);
    while (alive) {
      const Vec3f from = direction_;
      turn_path(rng);
      const auto pdf = [&] { return pdf_phase(Kind::phase(*component_), from, direction_); };
      const Vec3d start = flights_bring_light() ? traversal.position() : Vec3d{};
      const Hit hit = traversal.fly(direction_, rng);
      if (flights_bring_light()) add_on_the_way(start, hit, pdf, throughput_, rng);
      if (hit.component != nullptr) {
        alive = collide(*hit.component, rng) || resume();
      } else {
        add_scattered(s_, pdf, direction_, throughput_, r_);
        r_.scattered(scatterings_);
        alive = resume();
      }
    }
    return r_;
  }

  static constexpr bool kHasSurfaces = false;
  Traversal traversal;
  std::uint64_t collisions = 0, shadow_rays = 0;

 private:
  using Place = std::remove_cvref_t<decltype(std::declval<const Traversal&>().place())>;

  const PathSetup& s_;
  const Importance& importance_;
  PathResult r_;
  Vec3f direction_;                             // of the flight, in the world
  Rgb throughput_;                              // of the path
  std::uint32_t scatterings_ = 0;               // of the path, that at its place included
  const MediumComponent* component_ = nullptr;  // of the last collision
  const Importance::Row* row_ = nullptr;        // of its place
  Branches<Place> waiting_;

  /// Whether flights bring light besides that of their ends.
  [[nodiscard]] bool flights_bring_light() const {
    return !Kind::kSimple && s_.flights_bring_light();
  }
  /// Whether what emits along flights is a light.
  [[nodiscard]] bool samples_fires() const {
    return !Kind::kSimple && s_.samples_fires();
  }

  /// Adds what a collision gives of its own and by next-event estimation; whether the path goes on
  /// from there, by itself or split.
  [[nodiscard]] bool collide(const MediumComponent& component, Rng& rng) {
    ++collisions;
    if (s_.stopped()) return false;
    const auto& here = Kind::local(s_, traversal, component);
    add_emitted(s_, here, throughput_, r_);
    r_.scattered(scatterings_++);
    component_ = &component;
    row_ = &importance_.row(traversal.place());
    const float contribution = largest(throughput_) * row_->of(importance_.half_sine(direction_));
    if (!survives_by_contribution(contribution, throughput_, rng)) return false;
    throughput_ *= here.albedo;
    if (!(largest(throughput_) > 0)) return false;
    const float* importances = importance_.shadow_importance(*row_);
    const auto importance_of = [&](std::size_t light) { return importances[light]; };
    const PathVertex<Traversal> vertex{s_,  traversal,   direction_, throughput_,
                                       rng, shadow_rays, r_};
    add_light_here<Kind>(vertex, Kind::phase(component), importance_of);
    if (samples_fires()) add_fire_here(vertex, component.phase);
    r_.scattered(scatterings_);
    if (contribution > kSplitAbove && !waiting_.full())
      split(int(std::min(contribution, kMostCopies)));
    return true;
  }

  /// What a flight brings on its way.
  template <class Pdf>
  void add_on_the_way(Vec3d from, const Hit& hit, const Pdf& pdf, Rgb throughput, Rng& rng) {
    const bool collided = hit.component != nullptr;
    const double length = collided ? pvol::length(traversal.position() - from) : kEndless;
    const CollisionPlace end = collided && s_.emission ? traversal.collision() : CollisionPlace{};
    detail::add_on_the_way(s_, {from, direction_, length, end}, pdf, throughput, rng, r_);
  }

  /// Makes the path one of several equal ones that share its throughput.
  void split(int copies) {
    throughput_ *= 1 / float(copies);
    waiting_.add(
        {traversal.place(), component_, row_, direction_, throughput_, scatterings_, copies - 1});
  }

  /// Goes on with a branch that waits; false where none does.
  [[nodiscard]] bool resume() {
    const Branch<Place>* branch = waiting_.take();
    if (branch == nullptr) return false;
    traversal.return_to(branch->place);
    component_ = branch->component;
    row_ = branch->row;
    direction_ = branch->direction;
    throughput_ = branch->throughput;
    scatterings_ = branch->scatterings;
    return true;
  }

  void turn_path(Rng& rng) {
    direction_ = turn_by_importance<Kind>(importance_, *row_, Kind::phase(*component_), direction_,
                                          throughput_, rng);
  }
};

}  // namespace pvol::detail
