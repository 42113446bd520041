// Rays of scenes of many volumes, or of volumes among surfaces, as they are in the world: records
// have them in the cells of the volume where they fly.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "render/path/outside_shell.h"
#include "render/path/path_setup.h"
#include "render/path/roulette.h"

namespace pvol::detail {

/// Whether rays of the setup are kept in the world: they may meet several volumes or places, or
/// none, or surfaces, or see what moves at times of their own, or fly one by one.
[[nodiscard]] inline bool fly_in_the_world(const PathSetup& s) {
  const VolumeSetup& first = s.volumes.front();
  return !s.is_one_still() || s.moving || first.one_by_one || first.volume.density.octree.empty();
}

/// What rays do, each kind with queues of its own.
enum class RayKind : std::uint32_t { camera, path, shadow, to_fire, photon };
inline constexpr std::size_t kRayKinds = 5;

/// Where a ray enters the boxes of instances, of which there are few.
class Visits {
 public:
  struct Visit {
    double t0;
    std::uint32_t instance;
  };

  void clear() { n_ = 0, many_.clear(); }
  void add(double t0, std::uint32_t instance) {
    if (n_ < few_.size()) {
      few_[n_] = {t0, instance};
    } else {
      if (n_ == few_.size()) many_.assign(few_.begin(), few_.end());
      many_.push_back({t0, instance});
    }
    ++n_;
  }
  [[nodiscard]] std::size_t size() const { return n_; }
  [[nodiscard]] const Visit& operator[](std::size_t i) const {
    return n_ <= few_.size() ? few_[i] : many_[i];
  }
  /// Those from `first` on in the order in which they begin.
  void sort_from(std::size_t first) {
    Visit* const all = n_ <= few_.size() ? few_.data() : many_.data();
    std::sort(all + first, all + n_, [](const Visit& a, const Visit& b) {
      return std::pair(a.t0, a.instance) < std::pair(b.t0, b.instance);
    });
  }

 private:
  std::size_t n_ = 0;
  std::array<Visit, 3> few_;   // all of them, if they are not more: beside the rest of the ray
  std::vector<Visit> many_{};  // else
};

/// A ray, what lies on its way, and the nearest of the collisions that its flights have found:
/// those in each volume are independent, and the shortest is that of their sum (THEORY.md, T3.8).
struct alignas(64) WorldRay {
  static constexpr std::uint32_t kNowhere = ~0u;

  Ray ray{};
  double limit = kEndless;    ///< where it ends: at a light, or at a surface
  double nearest = kEndless;  ///< of its collisions
  RayKind kind = RayKind::camera;
  std::uint32_t hit = kNowhere;     ///< instance of the nearest collision
  std::uint32_t within = kNowhere;  ///< instance in which it begins
  float time = 0;                   ///< of its path, in frames
  std::uint32_t next = 0;           ///< of its visits
  bool searched = false;            ///< whether there are no others, and surfaces are known
  bool off_surface = false;         ///< it begins on one
  bool on_catcher = false;          ///< that is a shadow catcher before the camera
  Rgb throughput{1.0f};             ///< and then the path's: the record has that of flights alone
  Visits visits{};                  ///< those found so far
  Vec3f cells{};                    ///< place of the collision in its cells, as records have it
  Vec3d place{};                    ///< and in the world, once the ray has ended

  /// What surfaces make of it, once they are known.
  struct AmongSurfaces {
    bool hidden = false;   ///< of a shadow ray: one is in its way
    SurfaceHit surface{};  ///< the one that ends it, if it does not collide before
    // What paths bring where scattered rays meet other surfaces than shadow rays do: unscattered
    // light from so far, scattered light or none, times a factor (THEORY.md, T5.18).
    double direct_until = kEndless;
    double lamps_until = kEndless;  ///< a lamp may lie on the surface there
    bool scatters = true;
    float factor = 1;
  } among{};

  /// It begins in an instance, through which it flies first.
  void begin_within(std::uint32_t instance) {
    within = instance;
    visits.add(0, instance);
    next = 1;
  }
  /// It flies on there, from a distance on.
  void fly_on_within(double from) {
    visits.clear();
    visits.add(from, within);
    next = 0;
  }
  [[nodiscard]] double end() const { return std::min(nearest, limit); }
  /// Whether it ends by a collision.
  [[nodiscard]] bool collides() const { return hit != kNowhere; }
};

/// Decides what a path's ray brings where surfaces differ by kind of ray: where scattered light
/// comes from behind a surface that stops the rest, one of them is drawn, in proportion to about
/// what they are. What volumes scatter before such a surface is part of the scattered light, also
/// where that is black.
inline void choose_what_comes(const Surfaces& surfaces, WorldRay& r, Rng& rng) {
  constexpr float kOfVolumes = 0.5f;
  const auto end_direct_at = [&](const SurfaceHit& hit) {
    if (!(hit.distance < r.among.direct_until)) return;
    r.among.direct_until = hit.distance;
    r.among.lamps_until = hit.distance + hit.beyond_for_lamps();
  };
  const SurfaceHit shadow = surfaces.shadow->first_hit(r.ray, r.end(), r.time);
  if (shadow.material != nullptr) end_direct_at(shadow);
  const Material* const ahead = r.among.surface.material;
  if (ahead == nullptr) return;
  if (ahead->visible_shadow) end_direct_at(r.among.surface);
  if (!(r.among.surface.distance < r.among.direct_until)) return;
  const float weight = 1 + std::max(largest(ahead->albedo), kOfVolumes);
  if (rng.uniform() * weight < 1) {
    r.among.surface = {}, r.among.scatters = false, r.among.factor = weight;
  } else {
    r.among.direct_until = r.among.lamps_until = 0, r.among.factor = weight / (weight - 1);
  }
}

/// Finds the surface that a ray meets before all that it has met so far.
inline void find_surface(const Surfaces& surfaces, WorldRay& r, Rng rng) {
  r.among = {};
  if (r.kind == RayKind::shadow) {
    // From surfaces, lights that are hidden are not asked.
    r.among.hidden = !r.off_surface && surfaces.hide(r.ray, r.limit, r.time);
    return;
  }
  const SurfaceSet& met = r.kind == RayKind::camera    ? *surfaces.camera
                          : r.kind == RayKind::to_fire ? *surfaces.shadow
                                                       : *surfaces.scattered;
  // Copied where there is one: of all rays, most meet nothing.
  const SurfaceHit hit = met.first_hit(r.ray, r.end(), r.time);
  if (hit.material != nullptr) r.among.surface = hit;
  if (r.kind == RayKind::path && surfaces.shadows_differ()) choose_what_comes(surfaces, r, rng);
  if (r.among.surface.material == nullptr) return;
  r.limit = r.among.surface.distance;
  r.nearest = kEndless, r.hit = WorldRay::kNowhere;
}

/// limit = visit(instance, where a ray at a time enters its box, limit) for all before the limit
/// `end` but for one.
template <class Visit>
void visit_instances(const PathSetup& s, const Ray& ray, float time, double end, std::uint32_t but,
                     ShellCounts& shells, const Visit& visit) {
  s.instances->tree.visit(ray, end, [&](std::uint32_t i, double limit) {
    if (i == but) return limit;
    Instance moved;
    const Instance& at = s.instances->at_time(i, double(time), moved);
    const VolumeSetup& v = s.volumes[at.volume];
    const Ray cells = at.in_cells(ray);
    const auto span = v.in_box(cells);
    if (!span || !(span->t0 < limit)) return limit;
    if (outside_shell(v, cells, {span->t0, std::min(span->t1, limit)}, shells)) return limit;
    return visit(i, span->t0, limit);
  });
}

/// What a record has of its ray in the world is the number of a WorldRay; but of a ray that a
/// collision has made, as far as nothing but the instance of that bears on it (free_radii.h), the
/// number of the instance with this bit.
inline constexpr std::uint32_t kWithin = 1u << 31;
[[nodiscard]] inline bool is_within(std::uint32_t ray) { return (ray & kWithin) != 0; }
/// And this bit where a tentative collision in a thin volume around it ends the way so far.
inline constexpr std::uint32_t kMeetsThin = 1u << 30;
[[nodiscard]] inline std::uint32_t instance_within(std::uint32_t ray) {
  return ray & ~(kWithin | kMeetsThin);
}

/// Those that are on their way, by number.
class WorldRays {
 public:
  /// Number of one that has met nothing yet. What it is, its ray, time and end are to be set.
  [[nodiscard]] std::uint32_t add() {
    if (free_.empty()) free_.push_back(std::uint32_t(all_.size())), all_.emplace_back();
    const std::uint32_t number = free_.back();
    free_.pop_back();
    constexpr std::size_t kSoon = 4;
    if (free_.size() >= kSoon) prefetch(&free_[free_.size() - kSoon], 1);
    WorldRay& r = all_[number];
    r.nearest = kEndless, r.hit = r.within = WorldRay::kNowhere;
    r.next = 0, r.searched = r.off_surface = r.on_catcher = false;
    r.visits.clear();
    return number;
  }
  /// Of those that are within an instance there is nothing to remove.
  void remove(std::uint32_t number) {
    if (!is_within(number)) free_.push_back(number);
  }
  void clear() {
    free_.clear();
    for (std::size_t i = all_.size(); i > 0; --i) free_.push_back(std::uint32_t(i - 1));
  }
  [[nodiscard]] WorldRay& operator[](std::uint32_t number) { return all_[number]; }
  /// Fetches rays that are about to be asked for: there are more of them than caches hold.
  void prefetch(const std::uint32_t* numbers, std::size_t n) const {
    constexpr std::size_t kLine = 64, kLines = 4;
    for (std::size_t i = 0; i < n; ++i) {
      if (is_within(numbers[i])) continue;
      const char* const at = reinterpret_cast<const char*>(&all_[numbers[i]]);
      for (std::size_t line = 0; line < kLines; ++line) __builtin_prefetch(at + line * kLine);
    }
  }

  /// The next instance that a ray enters before it ends; null where there is none. A ray flies
  /// where it begins before it looks ahead: most collide there.
  [[nodiscard]] const Visits::Visit* next_visit(const PathSetup& s, WorldRay& r, const Rng& rng,
                                                ShellCounts& shells) {
    if (r.next == r.visits.size() || s.weighs) look_ahead(s, r, rng, shells);
    if (r.next == r.visits.size() || !(r.visits[r.next].t0 < r.end())) return nullptr;
    return &r.visits[r.next++];
  }

  /// Finds the surface and the other instances on a ray's way, once. Where flights have weights,
  /// they must not go on behind a surface: such rays look ahead before they fly.
  static void look_ahead(const PathSetup& s, WorldRay& r, const Rng& rng, ShellCounts& shells) {
    if (r.searched) return;
    r.searched = true;
    if (s.surfaces) find_surface(*s.surfaces, r, rng);
    if (!r.among.hidden) find_visits(s, r, shells);
  }

 private:
  static void find_visits(const PathSetup& s, WorldRay& r, ShellCounts& shells) {
    visit_instances(s, r.ray, r.time, r.end(), r.within, shells,
                    [&](std::uint32_t i, double t0, double limit) {
                      r.visits.add(t0, i);
                      return limit;
                    });
    r.visits.sort_from(r.next);
  }

  std::vector<WorldRay> all_;
  std::vector<std::uint32_t> free_;
};

}  // namespace pvol::detail
