// Light of lamps that a medium scatters into a path all along its flights, beside what it scatters
// where they end (THEORY.md, T5.25).
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "render/path/gather_light.h"

namespace pvol::detail {

/// Places in a span of a ray of unit direction, drawn evenly by the angle at which a lamp sees them
/// (Kulla, Fajardo 2012).
class EvenAngles {
 public:
  EvenAngles(Vec3d lamp, const Ray& ray, Span span);

  /// An angle from the begin of the span, as a number of the unit circle.
  struct Turn {
    double cosine, sine;

    [[nodiscard]] Turn operator*(Turn b) const {
      return {cosine * b.cosine - sine * b.sine, sine * b.cosine + cosine * b.sine};
    }
  };
  /// By this share of all angles.
  [[nodiscard]] Turn turn(double share) const;
  /// The place at an angle.
  [[nodiscard]] double at(Turn angle) const;

  /// The place up to which lies this share of all angles; and the other way round.
  [[nodiscard]] double at(double share) const { return at(turn(share)); }
  [[nodiscard]] double share_up_to(double t) const;
  /// Density per length.
  [[nodiscard]] double pdf(double t) const;

 private:
  double nearest_, apart_;  // where the ray passes the lamp, and how far from it
  double begin_;            // of the span
  double all_;              // the angle of the span

  [[nodiscard]] double angle_up_to(double t) const;
};

/// A flight through a volume at one of its places.
struct FlightThrough {
  const VolumeSetup& volume;
  Ray world;
  Ray cells;      ///< the same in the volume's cells
  double length;  ///< up to its end; infinite where it left
  float time;     ///< in frames
  Span box{};     ///< of its ray, in the volume's box; empty where it passes that

  FlightThrough(const VolumeSetup& v, const Ray& world_, const Ray& cells_, double length_,
                float time_)
      : volume(v),
        world(world_),
        cells(cells_),
        length(length_),
        time(time_),
        box(v.in_box(cells_).value_or(Span{})) {}

  /// Whether it gets into the box.
  [[nodiscard]] bool enters() const { return box.t1 > box.t0 && length > box.t0; }
};

/// A flight that ends at a collision, and the medium's extinction there.
struct CollidingFlight {
  FlightThrough flight;
  double extinction;

  explicit CollidingFlight(const FlightThrough& f);
};

/// The share of a lamp's light that the collision brings: flights bring the rest. 1 of a sun.
[[nodiscard]] float share_of_collision(const CollidingFlight& f, const Lamp& lamp);

/// Of a flight that enters the volume: a place on it from which a lamp is asked for all of it.
struct LampPoint {
  Vec3d place;
  LightSample towards;
  Rgb factor;             ///< on the lamp's radiance there: what the flight scatters into its path
  float over_collision;   ///< the factor over that of a collision there
  float collision_share;  ///< of the light from there, what collisions bring
};

/// What a pilot notes of lamps along flights (plan/lamp_trial.h).
struct LampPilot {
  struct Asked {
    Ray towards;
    double distance;
    /// By which the square of the path's luminance is less, if nothing is in the way, than on
    /// average where this light is found at collisions alone (THEORY.md, T5.25).
    double saved;
  };
  std::vector<Asked> asked{};
  std::uint64_t flights = 0;  ///< times lamps, whether these bring anything or not
};

/// Notes what a path gets of a lamp, as luminance: by a point that is taken 1/times as often as the
/// lamp is worth.
inline void note_lamp(LampPilot& pilot, double brought, const LampPoint& p, double times) {
  const double of_collisions = (1 + double(p.collision_share)) / (double(p.over_collision) * times);
  pilot.asked.push_back({{p.place, Vec3d(p.towards.direction)},
                         double(p.towards.distance),
                         brought * brought * (of_collisions - 1)});
}

/// Draws one by what it brings if nothing is in the way; none where the flight brings nothing.
[[nodiscard]] std::optional<LampPoint> draw_lamp_point(const FlightThrough& f,
                                                       const LightSource& light, const Lamp& lamp,
                                                       Rng& rng);

/// Of more lamps so many are drawn for a flight.
inline constexpr int kAskedAlong = 2;

/// ask(number, 1 / expected number of times that it is asked) for lamps along a flight; `cut` is
/// for its own use.
template <class Ask>
void ask_lamps(const FlightThrough& f, std::span<const Lamp> lamps, const ManyLights& many,
               LightCut& cut, Rng& rng, const Ask& ask) {
  if (!f.enters()) return;
  if (lamps.size() - many.suns() <= std::size_t(kAskedAlong)) {
    for (std::size_t i = 0; i < lamps.size(); ++i) {
      if (lamps[i].power > 0) ask(i, 1.0f);
    }
    return;
  }
  const AlongFlight at{f.world.at(f.box.t0), f.world.d, std::min(f.box.t1, f.length) - f.box.t0};
  many.draw(at, kAskedAlong, nullptr, cut, rng, ask);
}

}  // namespace pvol::detail
