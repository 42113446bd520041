// Volumes that move as a whole while the shutter is open.
#pragma once

#include <vector>

#include "pvol/math/moving_map.h"
#include "pvol/volume/shutter.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Where a volume is at one of its places: its own placement, then the instance's.
struct MovingPlace {
  MovingMap instance{}, object{};

  [[nodiscard]] bool moves() const { return instance.moves() || object.moves(); }
  /// From the object's space, after the density's own map, to the world.
  [[nodiscard]] Affine at(double frames) const { return instance.at(frames) * object.at(frames); }
};

/// The places of a volume of which some move: each is as the volume's maps have it where it does
/// not. Octree, shell and look-ups move along: they stand still in the volume's cells.
struct MovingPlaces {
  std::vector<MovingPlace> all;  ///< by number of the volume's places
  Shutter shutter;
  double longest = 0;  ///< way of a corner from its place at time 0, in world units
};

/// The same volume with places that move, whose number is that of the volume's and which are its
/// own at time 0. While the shutter is closed it only learns their velocities; one that has nothing
/// to move stays as it is. Comes last, after make_moving: the box of what the volume holds is then
/// known. Throws Error for a place that cannot be undone at all times of the shutter, or is out of
/// range there (validate_placement), and for homogenised nodes of a volume that grows.
[[nodiscard]] Volume move_places(Volume volume, std::vector<MovingPlace> places,
                                 const Shutter& shutter);

[[nodiscard]] inline bool places_move(const Volume& v) { return v.moving_places != nullptr; }
/// Whether this one does.
[[nodiscard]] inline bool place_moves(const Volume& v, std::size_t place) {
  return v.moving_places != nullptr && v.moving_places->all[place].moves();
}

/// From cells of the field to the object's space that a MovingPlace maps.
[[nodiscard]] Affine cells_to_object(const VolumeField& field, const Volume& volume);

/// Around a box of the object's space, mapped by `to_object` first, at all times from t0 to t1
/// (THEORY.md, T1.8): larger than need be by about a thousandth of its size, or by more where it
/// sweeps over many times that.
[[nodiscard]] Box swept_box(const MovingPlace& place, const Affine& to_object, const Box& box,
                            double t0, double t1);

}  // namespace pvol
