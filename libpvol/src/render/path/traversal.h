// How paths move: free flights and shadow rays through one volume, or through several at once.
#pragma once

#include "pvol/track/field.h"
#include "pvol/track/transmittance.h"
#include "pvol/volume/extinction_source.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// The field in which every question is a look-up.
template <LookUp kLookUp>
struct MakePlain {
  [[nodiscard]] auto operator()(const Volume& v) const {
    return PlainField{extinction_source<kLookUp>(v.density)};
  }
};

/// The field with micro-bounds.
template <LookUp kLookUp, int kEdge>
struct MakeSqueezed {
  [[nodiscard]] auto operator()(const Volume& v) const {
    const auto source = extinction_source<kLookUp>(v.density);
    return SqueezedField<kEdge, std::remove_const_t<decltype(source)>>{source, v.density.micro};
  }
};

/// f(constant) with a way of look-up that has closed forms in each cell: nearest or trilinear.
template <class F>
decltype(auto) visit_cells(LookUp look_up, const F& f) {
  if (look_up == LookUp::nearest) return f(std::integral_constant<LookUp, LookUp::nearest>{});
  return f(std::integral_constant<LookUp, LookUp::trilinear>{});
}

/// Where a flight of a path ended.
struct Hit {
  const Matter* matter = nullptr;  ///< what it collided with; null where it left
  float weight = 1;                ///< of the flight
};

/// The scene's tracker is chosen once a flight; it is the same all the time, so the branch costs
/// nothing, and the loops inside know it.
template <class Segments, class Field, class Count>
[[nodiscard, gnu::noinline]] Flight fly(Tracker tracker, Segments& segments, const Field& field,
                                        Rng& rng, Count& count) {
  switch (tracker) {
    case Tracker::decomposition:
      return free_flight<Tracker::decomposition>(segments, field, rng, count);
    case Tracker::weighted_delta:
      return free_flight<Tracker::weighted_delta>(segments, field, rng, count);
    case Tracker::weighted_decomposition:
      return free_flight<Tracker::weighted_decomposition>(segments, field, rng, count);
    case Tracker::regular:
      if constexpr (CellField<Field>) {
        return free_flight<Tracker::regular>(segments, field, rng, count);
      }
      break;                     // was refused by render()
    case Tracker::delta_global:  // delta on a tree of one terminal
    case Tracker::delta:
      break;
  }
  return free_flight<Tracker::delta>(segments, field, rng, count);
}

template <class Segments, class Field, class Count>
[[nodiscard]] float pass(Transmittance estimator, Tracker tracker, Segments& segments,
                         const Field& field, Rng& rng, Count& count) {
  switch (estimator) {
    case Transmittance::ratio:
      return is_weighted(tracker)
                 ? transmittance<Transmittance::ratio, Tracker::weighted_delta>(segments, field,
                                                                                rng, count)
                 : transmittance<Transmittance::ratio, Tracker::delta>(segments, field, rng, count);
    case Transmittance::residual_ratio:
      return transmittance<Transmittance::residual_ratio, Tracker::delta>(segments, field, rng,
                                                                          count);
    case Transmittance::regular:
      if constexpr (CellField<Field>) {
        return transmittance<Transmittance::regular, Tracker::delta>(segments, field, rng, count);
      }
      break;                        // was refused by render()
    case Transmittance::automatic:  // was resolved by render()
    case Transmittance::analog:
      break;
  }
  const Flight f = fly(tracker, segments, field, rng, count);
  return f.collided ? 0.0f : f.weight;
}

/// Counts of a traversal; nothing with NoTally.
template <class Count>
struct Work {
  Count path, shadow;
  std::uint64_t shell_tests = 0, shell_rejections = 0;
};

/// Whether a camera ray misses the volume's shell. It would meet no density then, and random
/// numbers are keyed by sample: the picture stays the same to the last bit.
template <class Count>
[[nodiscard]] bool outside_shell(const VolumeSetup& volume, const Ray& cells, const Span& span,
                                 Work<Count>& work) {
  if (!volume.shell) return false;
  ++work.shell_tests;
  const bool outside = volume.shell->misses(cells, span.t0, span.t1);
  work.shell_rejections += outside;
  return outside;
}

/// One volume: the cursor keeps the path's place in its octree from flight to flight. A ray that
/// has left the convex box cannot come back.
template <class MakeField, class Count>
class OneVolume {
 public:
  explicit OneVolume(const PathSetup& setup)
      : s_(setup), v_(setup.volumes.front()), field_(MakeField{}(v_.volume)) {}

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
    const Flight f = detail::fly(s_.options.tracker, walk, field_, rng, work.path);
    if (!f.collided) return {nullptr, f.weight};
    cursor_ = walk.stop_at(walk.point(f.t));
    return {&v_.choose_matter(rng), f.weight};
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
    return detail::pass(s_.options.transmittance, s_.options.tracker, walk, field_, rng,
                        work.shadow);
  }

  Work<Count> work;

 private:
  const PathSetup& s_;
  const VolumeSetup& v_;
  decltype(MakeField{}(v_.volume)) field_;
  Cursor cursor_;
};

/// Several volumes, which may overlap: free flights in each are independent, and the shortest one
/// is that of their sum (Kutz et al. 2017, theorem 1); transmittances multiply. No common tree is
/// needed. Weights of flights that end behind the shortest would count too much, so trackers are
/// analog here.
template <class MakeField, class Count>
class ManyVolumes {
 public:
  explicit ManyVolumes(const PathSetup& setup) : s_(setup) {
    for (const VolumeSetup& v : s_.volumes) fields_.push_back(MakeField{}(v.volume));
  }

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
    const Ray ray{position_, Vec3d(direction)};
    double nearest = std::numeric_limits<double>::infinity();
    const VolumeSetup* hit = nullptr;
    for (std::size_t i = 0; i < s_.volumes.size(); ++i) {
      const VolumeSetup& v = s_.volumes[i];
      const Ray cells = v.in_cells(ray);
      const auto span = v.in_box(cells);
      if (!span || span->t0 >= nearest) continue;
      Walk walk(v.volume.density.octree, make_cursor(v.volume.density.octree, cells.at(span->t0)),
                v.in_cells(direction), nearest - span->t0);
      const Flight f = detail::fly(s_.options.tracker, walk, fields_[i], rng, work.path);
      if (!f.collided || !(span->t0 + f.t < nearest)) continue;
      nearest = span->t0 + f.t;
      hit = &v;
    }
    if (hit == nullptr) return {};
    position_ = ray.at(nearest);
    return {&hit->choose_matter(rng), 1};
  }

  [[nodiscard]] Vec3d position() const { return position_; }

  [[nodiscard, gnu::noinline]] float pass(Vec3f direction, double distance, Rng& rng) {
    const Ray ray{position_, Vec3d(direction)};
    float product = 1;
    for (std::size_t i = 0; i < s_.volumes.size() && product != 0; ++i) {
      const VolumeSetup& v = s_.volumes[i];
      const Ray cells = v.in_cells(ray);
      const auto span = v.in_box(cells);
      if (!span || span->t0 >= distance) continue;
      Walk walk(v.volume.density.octree, make_cursor(v.volume.density.octree, cells.at(span->t0)),
                v.in_cells(direction), distance - span->t0);
      product *= detail::pass(s_.options.transmittance, s_.options.tracker, walk, fields_[i], rng,
                              work.shadow);
    }
    return product;
  }

  Work<Count> work;

 private:
  const PathSetup& s_;
  std::vector<decltype(MakeField{}(s_.volumes.front().volume))> fields_;
  Vec3d position_;
};

}  // namespace pvol::detail
