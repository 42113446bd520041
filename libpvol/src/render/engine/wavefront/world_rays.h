// Rays of scenes of many volumes, as they are in the world: records have them in the cells of the
// volume where they fly.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "render/path/path_setup.h"
#include "render/path/traversal.h"

namespace pvol::detail {

/// Whether rays of the setup are kept in the world: they may meet several volumes or places, or
/// none.
[[nodiscard]] inline bool fly_in_the_world(const PathSetup& s) {
  return !s.is_one_still() || s.volumes.front().volume.density.octree.empty();
}

/// A ray, what lies on its way, and the nearest of the collisions that its flights have found:
/// those in each volume are independent, and the shortest is that of their sum (THEORY.md, T3.8).
struct WorldRay {
  static constexpr std::uint32_t kNowhere = ~0u;

  struct Visit {
    double t0;  ///< where it enters the box of the instance
    std::uint32_t instance;
  };

  Ray ray;
  double limit = kEndless;          ///< where it ends: at a light
  double nearest = kEndless;        ///< of its collisions
  std::uint32_t hit = kNowhere;     ///< instance of that one
  Vec3f cells;                      ///< its place there, as records have it
  Vec3d place;                      ///< and in the world, once the ray has ended
  std::uint32_t within = kNowhere;  ///< instance in which it begins, by a collision there
  std::vector<Visit> visits;        ///< those found so far, in the order in which they begin
  std::size_t next = 0;             ///< of them
  bool searched = false;            ///< whether there are no others

  [[nodiscard]] double end() const { return std::min(nearest, limit); }
};

/// Those that are on their way, by number.
class WorldRays {
 public:
  /// One that has met nothing yet.
  [[nodiscard]] std::uint32_t add(const Ray& ray, double limit, std::uint32_t within) {
    if (free_.empty()) free_.push_back(std::uint32_t(all_.size())), all_.emplace_back();
    const std::uint32_t number = free_.back();
    free_.pop_back();
    WorldRay& r = all_[number];
    r.ray = ray, r.limit = limit, r.nearest = kEndless, r.hit = WorldRay::kNowhere;
    r.within = within, r.next = 0, r.searched = false;
    r.visits.clear();
    if (within != WorldRay::kNowhere) r.visits.push_back({0, within});
    return number;
  }
  void remove(std::uint32_t number) { free_.push_back(number); }
  void clear() {
    free_.clear();
    for (std::size_t i = all_.size(); i > 0; --i) free_.push_back(std::uint32_t(i - 1));
  }
  [[nodiscard]] WorldRay& operator[](std::uint32_t number) { return all_[number]; }

  /// The next instance that a ray enters before it ends; null where there is none. A ray flies
  /// where it begins before the others are searched for: most collide there.
  [[nodiscard]] const WorldRay::Visit* next_visit(const PathSetup& s, WorldRay& r, Work& work) {
    if (r.next == r.visits.size() && !r.searched) find_visits(s, r, work);
    if (r.next == r.visits.size() || !(r.visits[r.next].t0 < r.end())) return nullptr;
    return &r.visits[r.next++];
  }

 private:
  static void find_visits(const PathSetup& s, WorldRay& r, Work& work) {
    r.searched = true;
    s.instances->tree.visit(r.ray, r.end(), [&](std::uint32_t i, double limit) {
      if (i == r.within) return limit;
      const Instance& at = s.instances->all[i];
      const VolumeSetup& v = s.volumes[at.volume];
      const Ray cells = at.in_cells(r.ray);
      const auto span = v.in_box(cells);
      if (!span || !(span->t0 < limit)) return limit;
      if (outside_shell(v, cells, {span->t0, std::min(span->t1, limit)}, work)) return limit;
      r.visits.push_back({span->t0, i});
      return limit;
    });
    std::sort(r.visits.begin() + std::ptrdiff_t(r.next), r.visits.end(),
              [](const WorldRay::Visit& a, const WorldRay::Visit& b) {
                return std::pair(a.t0, a.instance) < std::pair(b.t0, b.instance);
              });
  }

  std::vector<WorldRay> all_;
  std::vector<std::uint32_t> free_;
};

}  // namespace pvol::detail
