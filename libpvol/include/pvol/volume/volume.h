// A cloud made ready for rendering: density in bricks, bounds as a tree with its cut chosen.
// Volumes are made by the calls of pvol/embed.h or, from bounds at hand, by those of make_volume.h.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pvol/bounds/octree.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/field/bounds_excess.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "pvol/math/names.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/medium.h"

namespace pvol {

struct AlbedoField;       // volume/albedo_field.h
struct BrickField;        // field/brick_field.h
struct Emitter;           // volume/emitter.h
struct HomogeneousParts;  // bounds/homogenise.h
struct LeafIndex;         // bounds/leaf_index.h
struct Motion;            // volume/motion.h
struct MovingPlaces;      // volume/moving_places.h
struct ProceduralField;   // field/procedural.h
struct SharedField;       // field/shared_field.h
struct FieldMap;          // math/field_map.h
struct Shell;             // shell/shell.h
struct SampleCodes;       // field/sample_codes.h

/// What decides tentative collisions before the density is looked up: micro-bounds, or samples as
/// bytes. The picture is the same to the last bit; trackers with weights do not use them.
enum class MicroBoundsUse {
  automatic,  ///< codes in pictures of nearest and trilinear fields; otherwise what pays
  none,
  edge_2,  ///< for cubes of 2^3 cells
  edge_1,  ///< for single cells
  codes,   ///< samples as bytes: for nearest and trilinear look-ups; others have edge_1 instead
};
[[nodiscard]] constexpr auto names(MicroBoundsUse) {
  return std::to_array<Named<MicroBoundsUse>>({
      {MicroBoundsUse::automatic, "auto"},
      {MicroBoundsUse::none, "none"},
      {MicroBoundsUse::edge_2, "2"},
      {MicroBoundsUse::edge_1, "1"},
      {MicroBoundsUse::codes, "codes"},
  });
}

/// Where look-ups read the samples of a grid. Results are the same.
enum class SampleStorage {
  automatic,  ///< shared in pictures by codes, which read few, of grids with an owner; else copied
  copied,     ///< in bricks with an apron, where look-ups are fastest
  shared,     ///< where they are, which the grid's owner or the caller keeps; batches go one by one
};

/// What a volume is made for, besides its medium.
struct VolumeOptions {
  /// Placed after the density's own map, index to object.
  Affine object_to_world{};
  /// Maps of the world, applied after that: the volume is there once under each, and its data are
  /// in memory once. Empty: it is there once, as it is.
  std::vector<Affine> instances{};
  LookUp look_up = LookUp::trilinear;                       ///< of samples; recipes are evaluated
  MicroBoundsUse micro_bounds = MicroBoundsUse::automatic;  ///< never changes a result
  std::optional<int> depth{};  ///< deepest octree level at which walks stop, 0 to
                               ///< kDeepestOctree; above it, and without, by cost
  Tracker tracker = Tracker::decomposition;
  /// Factor on majorants, for measurements: above 1 bounds get looser and the picture stays the
  /// same; below 1, down to 1/3, they do not bound, which takes a tracker with weights.
  double majorant_scale = 1;
  /// Of the density's values, after interpolation: majorants are as tight as the map's range, and
  /// what it makes 0 is empty. Null: none.
  std::shared_ptr<const FieldMap> map{};
  /// Biased: nodes that can change no ray's optical depth by more are homogeneous (homogenise.h).
  std::optional<double> homogenise{};
  /// Of the expected picture, which `automatic` choices must pay for; infinite for other uses.
  double paths = std::numeric_limits<double>::infinity();
  SampleStorage samples = SampleStorage::automatic;
};

/// What look-ups read: samples in bricks, a recipe, or samples of others; copies share it.
using FieldValues =
    std::variant<std::shared_ptr<const BrickField>, std::shared_ptr<const ProceduralField>,
                 std::shared_ptr<const SharedField>>;

/// Bricks without samples: those of an empty field.
[[nodiscard]] FieldValues empty_values();

/// A field of a volume, made ready for walks and look-ups: its bounds as a tree that is cut, its
/// values, and where its cells lie.
struct VolumeField {
  std::string name;                     ///< of the grid or recipe
  FieldValues values = empty_values();  ///< not null; in bricks that the octree's handles name
  LookUp look_up = LookUp::trilinear;
  std::shared_ptr<const FieldMap> map{};  ///< of values; null: none
  Octree octree;                          ///< of bounds of scale * value, mapped
  /// Of the octree, for look-ups at points; null where it would not be small beside the values.
  std::shared_ptr<const LeafIndex> leaves{};
  float scale = 1;            ///< rounded once for bounds and look-ups alike
  MicroBounds micro;          ///< of values, for the squeeze; of edge 0 where there is none
  bool micro_stored = false;  ///< whether they were given, not built
  std::shared_ptr<const SampleCodes> codes{};  ///< of values, in place of these; null: none
  Affine world_to_cells;                       ///< world to cells from the octree's origin
  Box world_box;                               ///< around the support; empty for an empty field
  /// Factors by which scale * value may exceed a majorant, and by which majorants are multiplied.
  double majorant_excess = 1, majorant_scale = 1;  // of weighted trackers; of others 1
  BoundsExcess excess;  ///< of the pyramid's bounds; without nodes where they hold
  std::shared_ptr<const HomogeneousParts> homogeneous;  ///< null: the options ask for none
  std::shared_ptr<const Motion> motion{};               ///< null: it stands still

  /// The bricks of samples; the field is no recipe and shares none.
  [[nodiscard]] const BrickField& bricks() const {
    return *std::get<std::shared_ptr<const BrickField>>(values);
  }
  /// The recipe; the field has no samples.
  [[nodiscard]] const ProceduralField& recipe() const {
    return *std::get<std::shared_ptr<const ProceduralField>>(values);
  }
  /// Whether look-ups read samples where they are, and the field that knows where.
  [[nodiscard]] bool shares_samples() const {
    return std::holds_alternative<std::shared_ptr<const SharedField>>(values);
  }
  [[nodiscard]] const SharedField& shared() const {
    return *std::get<std::shared_ptr<const SharedField>>(values);
  }
  /// Of all that look-ups read, of what is shared of it, and of what decides without them.
  [[nodiscard]] std::uint64_t value_bytes() const;
  [[nodiscard]] std::uint64_t shared_bytes() const;
  [[nodiscard]] std::uint64_t squeeze_bytes() const;
};

/// Everything a tracker needs to know of a cloud, for one extinction and placement. Safe to read
/// from any thread. Calls on rays and points (embed.h) see it at its first place; renders see all.
/// The medium's components may be exchanged for others; its extinction and the placement are those
/// of the bounds.
struct Volume {
  Medium medium{};
  Affine object_to_world{};  ///< of the first place
  /// Maps of the world that take the volume, fields, shell and fire, from its first place to each
  /// further one. Extinction is per world unit: at a place of another size the same bounds hold.
  std::vector<Affine> further_places{};
  VolumeField density{};                  ///< scaled to mu_t by the medium's extinction
  std::shared_ptr<const Shell> shell{};   ///< certified, in the density's index space; null: none
  std::shared_ptr<const Emitter> fire{};  ///< light of a field of its own; null: none
  std::string name{};                     ///< for messages
  std::shared_ptr<const AlbedoField> albedo{};             ///< multiplies the components'; or null
  std::shared_ptr<const MovingPlaces> moving_places{};     ///< null: no place moves
  std::shared_ptr<const Motion> velocities{};              ///< known with a closed shutter, too
  std::shared_ptr<const MovingPlaces> place_velocities{};  ///< likewise
};

}  // namespace pvol
