#include "render/light/emission/fire_at_collisions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "bounds/octree_children.h"
#include "pvol/field/brick_field.h"
#include "pvol/math/parallel.h"
#include "pvol/volume/value_field.h"
#include "volume/cell_look_up.h"
#include "volume/field_samples.h"

namespace pvol::detail {
namespace {

/// From the cells of the fire to those of the density, where these lie in one lattice whose leaves
/// are the same and are interpolated alike.
std::optional<Vec3i> shift_between(const VolumeField& fire, const VolumeField& density) {
  if (density.look_up != LookUp::trilinear || density.map || density.motion || fire.motion) {
    return std::nullopt;
  }
  constexpr double kAlike = 1e-6;  // cells over a whole leaf
  const Affine across = density.world_to_cells * inverse(fire.world_to_cells);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d unit(0);
    unit[axis] = 1;
    if (length(across.vector(unit) - unit) > kAlike / kLeafEdge) return std::nullopt;
  }
  const Vec3d shift = across.point(Vec3d(0)), leaves = shift / double(kLeafEdge);
  Vec3i whole;
  for (int axis = 0; axis < 3; ++axis) {
    const double nearest = std::round(leaves[axis]);
    if (!(std::abs(leaves[axis] - nearest) < kAlike) || !(std::abs(nearest) < 1e8)) {
      return std::nullopt;
    }
    whole[axis] = int(nearest) * kLeafEdge;
  }
  return whole;
}

/// A leaf of the fire with the bricks of both fields.
struct Leaf {
  Vec3i low;
  std::uint32_t brick;         ///< of the fire
  const float* emitted;        ///< its samples; null where it is no leaf but a larger cube
  std::uint32_t of_scatterer;  ///< of the density; kZeroBrick: there is none
};

std::vector<Leaf> leaves_of(const VolumeField& fire, const VolumeField& density, Vec3i shift) {
  const Octree& tree = density.octree;
  const int size = 1 << (Octree::child_log2(tree.height) + 2);
  std::vector<Leaf> leaves;
  for_bricks(
      fire.octree, fire.octree.nodes[0], Vec3i(0), [&](Vec3i low, int edge, std::uint32_t b) {
        const Vec3i there = low + shift;
        const bool inside = min_component(there) >= 0 && max_component(there) < size;
        const std::uint32_t other =
            inside ? brick_of_leaf(tree, widen(there), kZeroBrick) : kZeroBrick;
        leaves.push_back({low, b, edge == kLeafEdge ? fire.bricks().brick(b) : nullptr, other});
      });
  return leaves;
}

/// The largest luminance per value of the fire among a leaf's samples, one in each cube of `stride`
/// samples along the edges; 0 where what they are in is cold.
float brightest_of(const Emitter& fire, const Affine& to_world, const Leaf& leaf, int stride) {
  float brightest = 0;
  for (int i = 0; i < kFieldSamples; ++i) {
    const Vec3i at(i / (kFieldEdge * kFieldEdge), i / kFieldEdge % kFieldEdge, i % kFieldEdge);
    const bool asked = at.x % stride == 0 && at.y % stride == 0 && at.z % stride == 0;
    if (!asked || leaf.emitted[i] == 0) continue;
    const float color = fire.color_by
                            ? value_at(*fire.color_by, to_world.point(Vec3d(leaf.low + at)))
                            : leaf.emitted[i];
    const float light = luminance(emission(fire.fire, leaf.emitted[i], color));
    brightest = std::max(brightest, light / leaf.emitted[i]);
  }
  return brightest;
}

/// Whether paths collide wherever the leaf emits, and bring up to `most` then.
bool collides(const Volume& volume, const Affine& to_world, const Leaf& leaf, float most) {
  if (leaf.emitted == nullptr || leaf.of_scatterer == kZeroBrick) return false;
  std::array<float, kFieldSamples> scratch;
  const float* const scattered = samples_of(volume.density, leaf.of_scatterer, scratch.data());
  // Colours take long: one sample of eight tells enough, but that all is cold.
  float brightest = brightest_of(*volume.fire, to_world, leaf, 2);
  if (!(brightest > 0)) brightest = brightest_of(*volume.fire, to_world, leaf, 1);
  for (int i = 0; i < kFieldSamples; ++i) {
    if (leaf.emitted[i] == 0) continue;
    const float mu = volume.density.scale * scattered[i];
    if (!(mu > 0) || brightest * leaf.emitted[i] > most * mu) return false;
  }
  return true;
}

/// What of a tree of leaves and uniform cubes has other bricks.
class Pruning {
 public:
  Pruning(const Octree& from, const std::vector<std::uint32_t>& held) : from_(from), held_(held) {
    to_ = from;
    to_.nodes.clear(), to_.entries.clear();
    lo_ = widen(Vec3i(std::numeric_limits<int>::max()));
    hi_ = widen(Vec3i(std::numeric_limits<int>::min()));
    if (!copy(0, Vec3i(0))) to_ = {};
    to_.support_lo = max(lo_, from.support_lo), to_.support_hi = min(hi_, from.support_hi);
  }
  [[nodiscard]] Octree result() && { return std::move(to_); }

 private:
  /// Whether anything is left of a node, which comes after those before it then.
  bool copy(std::uint32_t index, Vec3i low) {
    const Octree::Node& node = from_.nodes[index];
    const std::size_t own = to_.nodes.size();
    to_.nodes.push_back({.height = node.height});
    const int edge = 1 << Octree::child_log2(int(node.height));
    std::vector<Octree::Entry> kept;
    std::uint64_t mask = 0;
    for (std::uint32_t bit = 0; bit < 64; ++bit) {
      const Octree::Entry* e = from_.child(node, bit);
      if (e == nullptr) continue;
      Octree::Entry entry = *e;
      const Vec3i at = low + Vec3i(int(bit >> 4), int(bit >> 2 & 3), int(bit & 3)) * edge;
      if (e->link & Octree::kNodeBit) {
        entry.link = Octree::kNodeBit | std::uint32_t(to_.nodes.size());
        if (!copy(e->link & ~Octree::kNodeBit, at)) continue;
      } else if (held_[e->link] != 0) {
        continue;
      } else {
        lo_ = min(lo_, widen(at)), hi_ = max(hi_, widen(at + Vec3i(edge)));
      }
      kept.push_back(entry);
      mask |= 1ull << bit;
    }
    if (mask == 0) {
      to_.nodes.resize(own);
      return false;
    }
    to_.nodes[own].mask = mask;
    to_.nodes[own].first = std::uint32_t(to_.entries.size());
    to_.entries.insert(to_.entries.end(), kept.begin(), kept.end());
    return true;
  }

  const Octree& from_;
  const std::vector<std::uint32_t>& held_;
  Octree to_;
  Int4 lo_{}, hi_{};  // of what is kept
};

}  // namespace

FireAtCollisions::FireAtCollisions(const Volume& volume, double most) : volume_(volume) {
  const VolumeField &fire = volume.fire->field, &density = volume.density;
  const Affine cells_to_world = inverse(density.world_to_cells);
  cells_to_fire_ = fire.world_to_cells * cells_to_world;
  if (const auto& color = volume.fire->color_by) {
    cells_to_color_ = color->world_to_cells * cells_to_world;
  }
  holds_.assign(fire.bricks().bricks(), 0);
  lines_ = fire.octree;
  if (fire.octree.empty() || density.octree.empty()) return;
  if (min_component(volume.medium.extinction_color) == 0) return;
  const auto shift = shift_between(fire, density);
  if (!shift) return;
  const Affine to_world = inverse(fire.world_to_cells);
  const std::vector<Leaf> leaves = leaves_of(fire, density, *shift);
  std::vector<char> held(leaves.size());
  parallel_for(0, leaves.size(), [&](std::size_t i) {
    held[i] = char(collides(volume, to_world, leaves[i], float(most)));
  });
  for (const Leaf& leaf : leaves) holds_[leaf.brick] = 1;
  for (std::size_t i = 0; i < leaves.size(); ++i) {  // bricks may serve several
    if (!held[i]) holds_[leaves[i].brick] = 0;
  }
  holds_any_ = std::ranges::find(holds_, 1u) != holds_.end();
  lines_ = Pruning(fire.octree, holds_).result();
}

Rgb FireAtCollisions::source(Vec3d cells) const {
  const Emitter& fire = *volume_.fire;
  const VolumeField& from = fire.field;
  const Vec3d at = cells_to_fire_.point(cells);
  if (!from.octree.support().contains(at)) return Rgb(0.0f);
  const LatticePoint p = lattice_point(from.octree, at);
  const std::uint32_t brick = from.octree.brick_at(leaf_at(from, p.cell), p.cell, kZeroBrick);
  if (holds_[brick] == 0) return Rgb(0.0f);
  const float mu = extinction_in_cells(volume_, cells);
  if (!(mu > 0)) return Rgb(0.0f);
  const float value = density_in_brick<LookUp::trilinear>(from.bricks().brick(brick), p);
  const float color =
      fire.color_by ? value_in(*fire.color_by, cells_to_color_.point(cells)) : value;
  const Rgb share = volume_.medium.extinction_color;
  return emission(fire.fire, value, color) * Rgb(1 / share.x, 1 / share.y, 1 / share.z) * (1 / mu);
}

}  // namespace pvol::detail
