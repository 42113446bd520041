// What emits as lights: directions towards it.
#pragma once

#include <memory>
#include <vector>

#include "render/light/emission/power_boxes.h"

namespace pvol::detail {

/// A source as a light: its boxes, which others share, at a place of its own. Times are in frames.
class PlacedPower {
 public:
  /// The boxes are not dark. Refers to where the source moves, if it does.
  PlacedPower(const EmissionSource& source, std::shared_ptr<const PowerBoxes> boxes);

  /// Where it is at a time.
  struct Place {
    Affine to_cells;
    double cell_volume;  ///< in the world
    Vec3d centre;
    double reach;  ///< of what shines, from the centre, squared
  };
  /// Of what moves in `moved`, which is to outlive the result.
  [[nodiscard]] const Place& at(float time, Place& moved) const {
    return source_.moves ? moved = place_at(time) : still_;
  }

  /// What a place of the world gets, about: power over squared distance.
  [[nodiscard]] double seen_from(Vec3d place, const Place& own) const;
  /// A point in the world.
  [[nodiscard]] Vec3d sample(Vec3d place, const Place& own, Rng& rng) const;
  /// Density per steradian of the directions from a place to its samples; that of unit direction
  /// d.
  [[nodiscard]] double pdf(Vec3d place, Vec3d d, const Place& own) const;

  // At the files' time:
  /// About what it emits per steradian.
  [[nodiscard]] double power() const { return still_.cell_volume * boxes_->power(); }
  /// A point in the world in proportion to that.
  [[nodiscard]] Vec3d sample(Rng& rng) const;
  [[nodiscard]] Vec3d centre() const { return still_.centre; }

 private:
  EmissionSource source_;
  std::shared_ptr<const PowerBoxes> boxes_;
  Place still_;

  [[nodiscard]] Place place_at(float time) const;
};

/// All sources of a scene as lights. Asks each of them, so that what many fires cost a collision is
/// in proportion to their number.
class EmissionLights {
 public:
  explicit EmissionLights(const std::vector<EmissionSource>& sources);

  struct Towards {
    Vec3f direction{};
    float pdf = 0;  ///< per steradian; 0: there is no light
  };
  /// At a time in frames.
  [[nodiscard]] Towards sample(Vec3d place, float time, Rng& rng) const;
  [[nodiscard]] float pdf(Vec3d place, Vec3f direction, float time) const;

  /// About what all emit per steradian [luminance times area], at the files' time.
  [[nodiscard]] double power() const;
  /// A point of the world in proportion to it.
  [[nodiscard]] Vec3d sample(Rng& rng) const;
  /// The middle of it; there is some.
  [[nodiscard]] Vec3d centre() const;

 private:
  std::vector<PlacedPower> lights_;
};

}  // namespace pvol::detail
