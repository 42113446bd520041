// How paths move through a volume whose extinction differs by channel.
#pragma once

#include "render/path/traversal.h"
#include "volume/chromatic_flights.h"

namespace pvol::detail {

/// Where a flight for all channels ended.
struct ChromaticHit {
  const MediumComponent* component = nullptr;  ///< what it collided with; null where it left
  Rgb weight{1.0f};
};

/// How far such a flight got.
struct ChromaticFreeFlight {
  double distance;  ///< world units; infinite where it left
  Rgb weight;
  CollisionPlace end{};  ///< where it did not
};

/// One volume, as OneVolume; flights go by what the path carries in each channel.
class ChromaticVolume {
 public:
  static constexpr bool kByChannel = true, kHasSurfaces = false;

  explicit ChromaticVolume(const PathSetup& setup)
      : work(setup), v_(setup.volumes.front()), share_(v_.volume.medium.extinction_color) {}

  [[nodiscard]] bool start(const Ray& ray) {
    const Ray cells = v_.in_cells(ray);
    const auto span = v_.in_box(cells);
    if (!span || outside_shell(v_, cells, *span, work)) return false;
    cursor_ = make_cursor(v_.volume.density.octree, cells.at(span->t0));
    return true;
  }

  [[nodiscard]] ChromaticHit fly(Vec3f direction, Rgb throughput, Rng& rng) {
    Walk walk = walk_to(direction, kEndless);
    const ChromaticFlight f =
        fly_chromatic(v_.volume.density, share_, throughput, walk, rng, work.path);
    if (!f.collided) return {nullptr, f.weight};
    cursor_ = walk.stop_at(walk.point(f.t));
    return {&v_.choose_component(rng), f.weight};
  }

  [[nodiscard]] Vec3d position() const {
    return v_.cells_to_world.point(pvol::position(cursor_.at));
  }

  /// Where the path's last flight collided.
  [[nodiscard]] CollisionPlace collision() const { return {&v_, pvol::position(cursor_.at)}; }

  /// Of light of all channels alike.
  [[nodiscard]] ChromaticFreeFlight free_flight(Vec3f direction, Rng& rng) {
    Walk walk = walk_to(direction, kEndless);
    const ChromaticFlight f =
        fly_chromatic(v_.volume.density, share_, Rgb(1.0f), walk, rng, work.shadow);
    if (!f.collided) return {kEndless, f.weight};
    return {f.t, f.weight, {&v_, pvol::position(walk.point(f.t))}};
  }

  [[nodiscard]] Rgb transmittance(Vec3f direction, double distance, Rng& rng) {
    Walk walk = walk_to(direction, distance);
    return chromatic_transmittance(v_.volume.density, share_, walk, rng, work.shadow);
  }

  Work work;

 private:
  [[nodiscard]] Walk walk_to(Vec3f direction, double distance) const {
    return {v_.volume.density.octree, cursor_, v_.in_cells(direction), distance};
  }

  const VolumeSetup& v_;
  Rgb share_;
  Cursor cursor_;
};

}  // namespace pvol::detail
