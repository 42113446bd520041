// How paths move: free flights and shadow rays through one volume, or through many at once.
#pragma once

#include "render/path/local_medium.h"

namespace pvol::detail {

/// Where a flight of a path ended.
struct Hit {
  const MediumComponent* component = nullptr;  ///< what it collided with; null where it left
  float weight = 1;                            ///< of the flight
};

/// How far a flight got.
struct FreeFlight {
  double distance;  ///< world units; infinite where it left
  float weight;
  CollisionPlace end{};  ///< where it did not
};
inline constexpr double kEndless = std::numeric_limits<double>::infinity();

/// Counts of a traversal; its tallies stay 0 where flights do not count.
struct Work {
  FlightMonitor path, shadow;
  std::uint64_t shell_tests = 0, shell_rejections = 0;

  explicit Work(const PathSetup& setup) : path{{}, setup.stop}, shadow{{}, setup.stop} {}

  /// Of a path: all its flights see what moves at one time.
  void set_time(float frames) { path.time = shadow.time = frames; }
};

/// Whether a ray misses the volume's shell. It would meet no density then; random numbers of camera
/// rays are keyed by sample: the picture of one volume stays the same to the last bit.
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
  /// Whether flights need the throughput and weigh each channel, and whether surfaces block light.
  static constexpr bool kByChannel = false, kHasSurfaces = false;

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
    return {&v_.choose_component(rng), f.weight};
  }

  /// A free flight from the path's place, which stays there: how far it gets, and its weight.
  [[nodiscard, gnu::noinline]] FreeFlight free_flight(Vec3f direction, Rng& rng) {
    Walk walk(v_.volume.density.octree, cursor_, v_.in_cells(direction));
    const Flight f = s_.flights.fly(s_.options.tracker, v_.volume.density, walk, rng, work.shadow);
    if (!f.collided) return {kEndless, f.weight};
    return {f.t, f.weight, {&v_, pvol::position(walk.point(f.t))}};
  }

  /// The path's place, to come back to.
  [[nodiscard]] const Cursor& place() const { return cursor_; }
  void return_to(const Cursor& place) { cursor_ = place; }

  /// Where the path is, in the world.
  [[nodiscard]] Vec3d position() const {
    return v_.cells_to_world.point(pvol::position(cursor_.at));
  }

  /// Where the path's last flight collided.
  [[nodiscard]] CollisionPlace collision() const { return {&v_, pvol::position(cursor_.at)}; }

  /// Transmittance from the path's place over a distance, or to the outside.
  [[nodiscard, gnu::noinline]] float transmittance(Vec3f direction, double distance, Rng& rng) {
    Walk walk(v_.volume.density.octree, cursor_, v_.in_cells(direction), distance);
    return s_.flights.transmittance(s_.options.transmittance, s_.options.tracker, v_.volume.density,
                                    walk, rng, work.shadow);
  }

  Work work;

 private:
  const PathSetup& s_;
  const VolumeSetup& v_;
  Cursor cursor_;
};

/// Where instances that stand still are.
class StillPlaces {
 public:
  explicit StillPlaces(const Instances& in) : in_(in) {}
  [[nodiscard]] const Instance& at(std::uint32_t i, float /*frames*/) const { return in_.all[i]; }

 private:
  const Instances& in_;
};

/// Where instances are at the time of a path, of which some move. All flights of a path ask for the
/// same ones: those that were asked for last are kept.
class MovingPlacesAt {
 public:
  explicit MovingPlacesAt(const Instances& in) : in_(in), kept_(kKept) {}

  /// Until the next call.
  [[nodiscard]] const Instance& at(std::uint32_t i, float frames) {
    if (in_.motion[i].place == nullptr) return in_.all[i];
    Kept& k = kept_[i % kKept];
    if (k.number != i || k.frames != frames) k = {i, frames, in_.at_time(i, double(frames))};
    return k.instance;
  }

 private:
  static constexpr std::uint32_t kKept = 64;
  struct Kept {
    std::uint32_t number = ~0u;
    float frames = 0;
    Instance instance{};
  };

  const Instances& in_;
  std::vector<Kept> kept_;
};

/// Many volumes, or one at many places, or one that moves as a whole, which may overlap: free
/// flights in each are independent, and the shortest one is that of their sum (Kutz et al. 2017,
/// theorem 1); transmittances multiply (THEORY.md, T3.8). A tree of boxes tells which to ask; no
/// common octree is needed. Weights of flights that end behind the shortest would count too much,
/// so trackers are analog here.
template <class Places>
class VolumesAt {
 public:
  static constexpr bool kByChannel = false, kHasSurfaces = false;

  explicit VolumesAt(const PathSetup& setup)
      : work(setup), s_(setup), in_(*setup.instances), places_(in_) {}

  /// Moves to where the first volume begins: from there on float directions are precise enough.
  [[nodiscard]] bool start(const Ray& ray) {
    const double first = first_box(ray, kEndless);
    if (first == kEndless) return false;
    move_to(ray.at(first));
    return true;
  }

  /// Distance to where the first volume before the limit begins; infinite where none does.
  [[nodiscard]] double first_box(const Ray& ray, double end) {
    double first = kEndless;
    in_.tree.visit(ray, end, [&](std::uint32_t i, double limit) {
      const Instance& at = places_.at(i, work.path.time);
      const auto span = s_.volumes[at.volume].in_box(at.in_cells(ray));
      if (span && span->t0 < limit) first = span->t0;
      return std::min(first, limit);
    });
    return first;
  }

  /// A flight that ends at the limit, if nothing ends it before; the path stays where it is then.
  [[nodiscard]] Hit fly(Vec3f direction, Rng& rng, double limit = kEndless) {
    const auto [nearest, hit] = find_nearest(direction, limit, rng, work.path);
    if (hit == nullptr) return {};
    place_ = {Ray{place_.position, Vec3d(direction)}.at(nearest), hit};
    return {&s_.volumes[hit->volume].choose_component(rng), 1};
  }

  [[nodiscard, gnu::noinline]] FreeFlight free_flight(Vec3f direction, Rng& rng,
                                                      double limit = kEndless) {
    const auto [nearest, hit] = find_nearest(direction, limit, rng, work.shadow);
    if (hit == nullptr) return {nearest, 1};
    const Vec3d end = Ray{place_.position, Vec3d(direction)}.at(nearest);
    return {nearest, 1, collision_at({end, hit})};
  }

  [[nodiscard]] Vec3d position() const { return place_.position; }
  /// To a place that no collision is known of.
  void move_to(Vec3d position) { place_ = {position}; }

  [[nodiscard]] const WorldPlace& place() const { return place_; }
  void return_to(const WorldPlace& place) { place_ = place; }

  /// Where the path's last flight collided.
  [[nodiscard]] CollisionPlace collision() const { return collision_at(place_); }

  [[nodiscard, gnu::noinline]] float transmittance(Vec3f direction, double distance, Rng& rng) {
    float product = 1;
    visit_walks(direction, distance, [&](const Instance& at, double, double limit, Walk& walk) {
      product *= s_.flights.transmittance(s_.options.transmittance, s_.options.tracker, field(at),
                                          walk, rng, work.shadow);
      return product == 0 ? 0 : limit;
    });
    return product;
  }

  /// Whether a ray from the path's place may meet density before a distance.
  [[nodiscard]] bool meets_any(Vec3f direction, double distance) {
    bool meets = false;
    visit_boxes(direction, distance,
                [&](const Instance&, const Instance&, const Ray&, double, double) {
                  meets = true;
                  return 0.0;  // ends the visit
                });
    return meets;
  }

  Work work;

 private:
  struct Nearest {
    double distance;
    const Instance* hit;  ///< null: there is none
  };

  [[nodiscard]] CollisionPlace collision_at(const WorldPlace& place) const {
    const auto number = std::uint32_t(place.within - in_.all.data());
    const Instance in = in_.at_time(number, double(work.path.time));
    return {&s_.volumes[in.volume], in.world_to_cells.point(place.position)};
  }

  [[nodiscard]] const VolumeField& field(const Instance& at) const {
    return s_.volumes[at.volume].volume.density;
  }

  /// limit = visit(instance of all, as it is at the time, ray in its cells, where it begins, limit)
  /// for those that a ray from the path's place may meet before it.
  template <class Visit>
  void visit_boxes(Vec3f direction, double distance, const Visit& visit) {
    const Ray ray{place_.position, Vec3d(direction)};
    in_.tree.visit(ray, distance, [&](std::uint32_t i, double limit) {
      const Instance& at = places_.at(i, work.path.time);
      const VolumeSetup& v = s_.volumes[at.volume];
      const Ray cells = at.in_cells(ray);
      const auto span = v.in_box(cells);
      if (!span || span->t0 >= limit) return limit;
      // What scattered the path holds it: its shell would not turn the ray away.
      if (&in_.all[i] != place_.within &&
          outside_shell(v, cells, {span->t0, std::min(span->t1, limit)}, work)) {
        return limit;
      }
      return visit(in_.all[i], at, cells, span->t0, limit);
    });
  }

  /// limit = visit(instance of all, where it begins, limit, walk from there up to the limit), for
  /// the same.
  template <class Visit>
  void visit_walks(Vec3f direction, double distance, const Visit& visit) {
    visit_boxes(
        direction, distance,
        [&](const Instance& in, const Instance& at, const Ray& cells, double t0, double limit) {
          const Octree& tree = s_.volumes[at.volume].volume.density.octree;
          Walk walk(tree, make_cursor(tree, cells.at(t0)), at.in_cells(direction), limit - t0);
          return visit(in, t0, limit, walk);
        });
  }

  /// The shortest of the flights through all, and whose it is; the limit and none where that is
  /// shorter.
  [[nodiscard]] Nearest find_nearest(Vec3f direction, double end, Rng& rng,
                                     FlightMonitor& monitor) {
    Nearest nearest{end, nullptr};
    visit_walks(direction, end, [&](const Instance& at, double t0, double limit, Walk& walk) {
      const Flight f = s_.flights.fly(s_.options.tracker, field(at), walk, rng, monitor);
      if (!f.collided || !(t0 + f.t < limit)) return limit;
      nearest = {t0 + f.t, &at};
      return t0 + f.t;
    });
    return nearest;
  }

  const PathSetup& s_;
  const Instances& in_;
  Places places_;
  WorldPlace place_;
};

using ManyVolumes = VolumesAt<StillPlaces>;
using MovingVolumes = VolumesAt<MovingPlacesAt>;

}  // namespace pvol::detail
