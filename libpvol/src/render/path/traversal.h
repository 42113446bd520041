// How paths move: free flights and shadow rays through one volume, or through several at once.
#pragma once

#include "render/path/path_setup.h"

namespace pvol::detail {

/// Where a flight of a path ended.
struct Hit {
  const Matter* matter = nullptr;  ///< what it collided with; null where it left
  float weight = 1;                ///< of the flight
};

/// How far a flight got.
struct Reach {
  double distance;  ///< world units; infinite where it left
  float weight;
};
inline constexpr double kEndless = std::numeric_limits<double>::infinity();

/// Counts of a traversal; its tallies stay 0 where flights do not count.
struct Work {
  Watch path, shadow;
  std::uint64_t shell_tests = 0, shell_rejections = 0;

  explicit Work(const PathSetup& setup) : path{{}, setup.stop}, shadow{{}, setup.stop} {}

  /// Of a path: all its flights see what moves at one time.
  void set_time(float frames) { path.time = shadow.time = frames; }
};

/// Whether a camera ray misses the volume's shell. It would meet no density then, and random
/// numbers are keyed by sample: the picture stays the same to the last bit.
[[nodiscard]] inline bool outside_shell(const VolumeSetup& volume, const Ray& cells,
                                        const Span& span, Work& work) {
  if (!volume.shell) return false;
  ++work.shell_tests;
  const bool outside = volume.shell->misses(cells, span.t0, span.t1);
  work.shell_rejections += outside;
  return outside;
}

/// One volume: the cursor keeps the path's place in its octree from flight to flight. A ray that
/// has left the convex box cannot come back.
class OneVolume {
 public:
  explicit OneVolume(const PathSetup& setup) : work(setup), s_(setup), v_(setup.volumes.front()) {}

  /// Whether the camera's ray may meet the volume.
  [[nodiscard]] bool start(const Ray& ray) {
    const Ray cells = v_.in_cells(ray);
    const auto span = v_.in_box(cells);
    if (!span || outside_shell(v_, cells, *span, work)) return false;
    cursor_ = make_cursor(v_.volume.density.octree, cells.at(span->t0));
    return true;
  }

  [[nodiscard]] Hit fly(Vec3f direction, Rng& rng) {
    Walk walk(v_.volume.density.octree, cursor_, v_.in_cells(direction));
    const Flight f = s_.flights.fly(s_.options.tracker, v_.volume.density, walk, rng, work.path);
    if (!f.collided) return {nullptr, f.weight};
    cursor_ = walk.stop_at(walk.point(f.t));
    return {&v_.choose_matter(rng), f.weight};
  }

  /// A free flight from the path's place, which stays there: how far it gets, and its weight.
  [[nodiscard, gnu::noinline]] Reach reach(Vec3f direction, Rng& rng) {
    Walk walk(v_.volume.density.octree, cursor_, v_.in_cells(direction));
    const Flight f = s_.flights.fly(s_.options.tracker, v_.volume.density, walk, rng, work.shadow);
    return {f.collided ? f.t : kEndless, f.weight};
  }

  /// The path's place, to come back to.
  [[nodiscard]] const Cursor& place() const { return cursor_; }
  void return_to(const Cursor& place) { cursor_ = place; }

  /// Where the path is, in the world.
  [[nodiscard]] Vec3d position() const {
    return v_.cells_to_world.point(pvol::position(cursor_.at));
  }

  /// Transmittance from the path's place over a distance, or to the outside.
  [[nodiscard, gnu::noinline]] float pass(Vec3f direction, double distance, Rng& rng) {
    Walk walk(v_.volume.density.octree, cursor_, v_.in_cells(direction), distance);
    return s_.flights.pass(s_.options.transmittance, s_.options.tracker, v_.volume.density, walk,
                           rng, work.shadow);
  }

  Work work;

 private:
  const PathSetup& s_;
  const VolumeSetup& v_;
  Cursor cursor_;
};

/// Several volumes, which may overlap: free flights in each are independent, and the shortest one
/// is that of their sum (Kutz et al. 2017, theorem 1); transmittances multiply. No common tree is
/// needed. Weights of flights that end behind the shortest would count too much, so trackers are
/// analog here.
class ManyVolumes {
 public:
  explicit ManyVolumes(const PathSetup& setup) : work(setup), s_(setup) {}

  /// Moves to where the first volume begins: from there on float directions are precise enough.
  [[nodiscard]] bool start(const Ray& ray) {
    double first = std::numeric_limits<double>::infinity();
    for (const VolumeSetup& v : s_.volumes) {
      const Ray cells = v.in_cells(ray);
      const auto span = v.in_box(cells);
      if (!span || outside_shell(v, cells, *span, work)) continue;
      first = std::min(first, span->t0);
    }
    if (!std::isfinite(first)) return false;
    position_ = ray.at(first);
    return true;
  }

  [[nodiscard]] Hit fly(Vec3f direction, Rng& rng) {
    const VolumeSetup* hit = nullptr;
    const double nearest = find_nearest(direction, rng, work.path, hit);
    if (hit == nullptr) return {};
    position_ = Ray{position_, Vec3d(direction)}.at(nearest);
    return {&hit->choose_matter(rng), 1};
  }

  [[nodiscard, gnu::noinline]] Reach reach(Vec3f direction, Rng& rng) {
    const VolumeSetup* hit = nullptr;
    return {find_nearest(direction, rng, work.shadow, hit), 1};
  }

  [[nodiscard]] Vec3d position() const { return position_; }

  [[nodiscard, gnu::noinline]] float pass(Vec3f direction, double distance, Rng& rng) {
    const Ray ray{position_, Vec3d(direction)};
    float product = 1;
    for (const VolumeSetup& v : s_.volumes) {
      if (product == 0) break;
      const Ray cells = v.in_cells(ray);
      const auto span = v.in_box(cells);
      if (!span || span->t0 >= distance) continue;
      Walk walk(v.volume.density.octree, make_cursor(v.volume.density.octree, cells.at(span->t0)),
                v.in_cells(direction), distance - span->t0);
      product *= s_.flights.pass(s_.options.transmittance, s_.options.tracker, v.volume.density,
                                 walk, rng, work.shadow);
    }
    return product;
  }

  Work work;

 private:
  /// The shortest of the volumes' flights, and whose it is.
  [[nodiscard]] double find_nearest(Vec3f direction, Rng& rng, Watch& watch,
                                    const VolumeSetup*& hit) const {
    const Ray ray{position_, Vec3d(direction)};
    double nearest = kEndless;
    for (const VolumeSetup& v : s_.volumes) {
      const Ray cells = v.in_cells(ray);
      const auto span = v.in_box(cells);
      if (!span || span->t0 >= nearest) continue;
      Walk walk(v.volume.density.octree, make_cursor(v.volume.density.octree, cells.at(span->t0)),
                v.in_cells(direction), nearest - span->t0);
      const Flight f = s_.flights.fly(s_.options.tracker, v.volume.density, walk, rng, watch);
      if (!f.collided || !(span->t0 + f.t < nearest)) continue;
      nearest = span->t0 + f.t;
      hit = &v;
    }
    return nearest;
  }

  const PathSetup& s_;
  Vec3d position_;
};

}  // namespace pvol::detail
