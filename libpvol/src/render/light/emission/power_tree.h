// Emitted power by place, to sample directions towards what shines.
#pragma once

#include <memory>
#include <vector>

#include "math/philox.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/math/box.h"
#include "render/light/emission/emission_source.h"

namespace pvol::detail {

/// Boxes around what shines in a field's octree, in a tree of at most eight children a node, with
/// the power that each emits: in cells, so that all places of a field share it. A place sees a node
/// by its power over the squared distance, no nearer than its radius; from node to node a box is
/// chosen in proportion to that, and a point in it evenly. The density
/// of directions follows exactly, whatever the powers: they need not be (THEORY.md, T5.12).
/// Based on: Simon, Hanika, Zirr, Dachsbacher. Line integration for rendering heterogeneous
/// emissive volumes. 2017; Villemin, Hery. Practical illumination from flames. 2013.
class PowerTree {
 public:
  struct Node {
    Vec3f lo, hi;     ///< cells
    float power = 0;  ///< in cells; that of a cube of this luminance a world unit: its volume
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< of children; 0: a box
    [[nodiscard]] float seen_from(Vec3f cell) const;
  };

  /// Of a source that is not empty; estimates powers by a few points of each cube.
  explicit PowerTree(const EmissionSource& source);

  /// Null where all is dark.
  [[nodiscard]] const Node* root() const { return nodes_.empty() ? nullptr : &nodes_.front(); }

  /// A point in cells; the tree is not dark.
  [[nodiscard]] Vec3d sample(Vec3f cell, Rng& rng) const;

  /// A point in cells in proportion to the power, about.
  [[nodiscard]] Vec3d sample(Rng& rng) const;

  /// Density of the directions from the origin of a ray in cells to its samples, per steradian of a
  /// world in which the ray's t is length and a cell has this volume; 0 where all is dark.
  [[nodiscard]] double pdf(const Ray& cells, double cell_volume) const;

  struct Cube;  ///< of the octree

 private:
  struct Line;

  template <class Weight>
  [[nodiscard]] Vec3d sample_by(const Weight& weight, Rng& rng) const;

  /// Neighbours joined, in ever larger cubes of the lattice, until they are few.
  [[nodiscard]] static std::vector<Node> join(std::vector<Node> cubes);
  void build(std::vector<Node>& cubes, std::size_t begin, std::size_t end, int shift,
             std::size_t at);
  [[nodiscard]] double pdf(const Line& line, const Node& node, double share) const;

  std::vector<Node> nodes_;  ///< the root first, children side by side; none: all is dark
};

/// A source as a light: its tree, which others share, at a place of its own. Times are in frames.
class PlacedPower {
 public:
  /// The tree is not dark. Refers to where the source moves, if it does.
  PlacedPower(const EmissionSource& source, std::shared_ptr<const PowerTree> tree);

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
  [[nodiscard]] double power() const { return still_.cell_volume * double(tree_->root()->power); }
  /// A point in the world in proportion to that.
  [[nodiscard]] Vec3d sample(Rng& rng) const;
  [[nodiscard]] Vec3d centre() const { return still_.centre; }

 private:
  EmissionSource source_;
  std::shared_ptr<const PowerTree> tree_;
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
