// What is integrated along lines: what fires and thin media emit along flights, and optical depths.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "pvol/bounds/walk.h"
#include "pvol/render/options.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/moving_places.h"
#include "pvol/volume/volume.h"
#include "render/light/emission/fire_at_collisions.h"

namespace pvol::detail {

/// A field that emits at one of its volume's places, ready for lines through it. Refers to the
/// volume.
struct EmissionSource {
  std::size_t volume = 0;              ///< number of the volume
  const VolumeField* field = nullptr;  ///< where it is not 0
  const Emitter* fire = nullptr;       ///< or null:
  Rgb of_depth{0.0f};                  ///< what the medium emits per unit of optical depth
  int points = 1;                      ///< of a line, for each leaf's edge on its way
  int least = 1;                       ///< in each segment; of a medium's line in lanes
  Affine to_first{};  ///< from its place to the volume's first one, where the field is
  Box box{};          ///< around its place in the world, at all times
  const MovingPlace* moves = nullptr;   ///< with its volume; null: it stands still
  Affine object_to_first{};             ///< where it moves
  const AlbedoField* albedo = nullptr;  ///< of the medium; or null, else of_depth is what it would
                                        ///< emit if it were black, and
  Rgb per_color{0.0f};                  ///< how much less, by the field's colour
  std::shared_ptr<const FireAtCollisions> at_collisions{};  ///< of the fire; or null
  bool in_lanes = false;    ///< whether lanes look up what the fire emits, and
  Affine cells_to_color{};  ///< from its cells to those of its colour's field, if it has one

  /// At a time in frames.
  [[nodiscard]] Affine to_first_at(float time) const {
    return moves ? object_to_first * inverse(moves->at(double(time))) : to_first;
  }
  [[nodiscard]] bool is_medium() const { return fire == nullptr; }
  /// Whether each unit of optical depth emits as much as any other.
  [[nodiscard]] bool is_even_medium() const { return is_medium() && albedo == nullptr; }
  /// Where lines gather light: without what collisions bring.
  [[nodiscard]] const Octree& lines() const {
    return at_collisions ? at_collisions->lines() : field->octree;
  }

  /// Radiance per world unit at a point of a segment of the field, that lay there at the files'
  /// time in the world of the first place.
  template <class Mu>
  [[nodiscard]] Rgb at(const Mu& value, const Segment& s, const LatticePoint& p,
                       Vec3d world) const {
    const float v = value(s, p);
    if (is_even_medium()) return of_depth * v;
    if (fire == nullptr) return (of_depth - per_color * color_at(*albedo, world)) * v;
    return emission(fire->fire, v, fire->color_by ? value_at(*fire->color_by, world) : v);
  }
};

/// Points of a line that has so many times fewer than others.
[[nodiscard]] inline int fewer_points(int points, int fewer) { return std::max(points / fewer, 1); }

/// Whether what the medium of the volume emits is gathered along flights, not at collisions.
[[nodiscard]] bool gathers_along_flights(const Volume& volume, const RenderOptions& options);

/// What emits along flights in these volumes: fires, and thin media; those of one field
/// side by side.
[[nodiscard]] std::vector<EmissionSource> emission_sources(std::span<const Volume> volumes,
                                                           const RenderOptions& options);

/// Each place of each volume, which emits 1 per optical depth of a channel: lines find depths.
[[nodiscard]] std::vector<EmissionSource> depth_sources(std::span<const Volume> volumes);

/// The integral of what the source emits along a ray of the world of unit direction, up to a
/// distance that may be infinite, at a time in frames, by points spread over the segments of its
/// octree, so many times fewer than the source has. With u uniform in [0, 1) right on average,
/// exact where emission is the same along each of these pieces (THEORY.md, T5.11).
[[nodiscard]] Rgb integrate(const EmissionSource& source, const Ray& ray, double distance,
                            float time, float u, int fewer);

}  // namespace pvol::detail
