// Grids of vectors, or of numbers, as the components of vectors.
#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "file/grid_names.h"
#include "pvol/density/voxel_grid.h"
#include "vdb/vdb_inspect.h"

namespace pvol::formats::detail {

[[nodiscard]] inline bool is_vector(const VdbGrid& grid) {
  return grid.type == "Tree_vec3s_5_4_3" || grid.type == "Tree_vec3d_5_4_3";
}
[[nodiscard]] inline bool is_number(const VdbGrid& grid) {
  return grid.type == "Tree_float_5_4_3" || grid.type == "Tree_double_5_4_3";
}

/// The first of the file's grids that has this name and fits; null where there is none.
[[nodiscard]] inline const VdbGrid* find_grid(const VdbFile& file, std::string_view name,
                                              bool (*fits)(const VdbGrid&)) {
  for (const VdbGrid& grid : file.grids) {
    if (fits(grid) && (same_name(grid.name, name) || same_name(grid.base, name))) return &grid;
  }
  return nullptr;
}

/// Collects the active values of trees as three components, and where they are.
/// clean(value, samples) is what is kept of so many samples of a component.
template <class Clean>
class VectorCollector {
 public:
  explicit VectorCollector(Clean clean) : clean_(std::move(clean)) {}

  /// Of a grid of vectors or of numbers: component c of its values is along axis first + c.
  void add(const openvdb::GridBase::Ptr& grid, int first) {
    if (const auto v = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) return add(v->tree(), first);
    if (const auto v = openvdb::gridPtrCast<openvdb::Vec3DGrid>(grid)) return add(v->tree(), first);
    if (const auto v = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return add(v->tree(), first);
    add(openvdb::gridPtrCast<openvdb::DoubleGrid>(grid)->tree(), first);
  }

  /// The components, and 1 where a value of the first one is active.
  [[nodiscard]] std::array<VoxelGrid, 4> take(const Affine& index_to_world,
                                              const std::string& name) && {
    std::array<VoxelGrid, 4> grids;
    for (std::size_t c = 0; c < 4; ++c) {
      grids[c].name = name;
      grids[c].index_to_world = index_to_world;
      grids[c].bricks = std::move(bricks_[c]);
      grids[c].tiles = std::move(tiles_[c]);
      grids[c].owner = samples_;
    }
    return grids;
  }

 private:
  using Samples = std::array<float, kBrickSamples>;

  Clean clean_;
  std::shared_ptr<std::deque<Samples>> samples_ = std::make_shared<std::deque<Samples>>();
  std::array<std::vector<Brick>, 4> bricks_;
  std::array<std::vector<Tile>, 4> tiles_;
  const float* ones_ = nullptr;  ///< of leaves that are active all over

  template <class T>
  static float component(const T& value, int c) {
    if constexpr (openvdb::VecTraits<T>::IsVec) {
      return float(value[c]);
    } else {
      (void)c;
      return float(value);
    }
  }

  /// The mask of a leaf as samples.
  template <class Leaf>
  const float* active(const Leaf& leaf) {
    if (leaf.getValueMask().isOn() && ones_ != nullptr) return ones_;
    Samples& to = samples_->emplace_back();
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) to[i] = leaf.getValueMask().isOn(i) ? 1 : 0;
    if (leaf.getValueMask().isOn()) ones_ = to.data();
    return to.data();
  }

  template <class Tree>
  void add(const Tree& tree, int first) {
    constexpr int kComponents = openvdb::VecTraits<typename Tree::ValueType>::Size;
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
      const openvdb::Coord o = leaf->origin();
      const Vec3i origin(o.x(), o.y(), o.z());
      std::array<Samples*, 3> to{};
      for (int c = 0; c < kComponents; ++c) {
        to[std::size_t(c)] = &samples_->emplace_back();
        to[std::size_t(c)]->fill(0);
        bricks_[std::size_t(first + c)].push_back({origin, to[std::size_t(c)]->data()});
      }
      for (auto value = leaf->cbeginValueOn(); value; ++value) {
        for (int c = 0; c < kComponents; ++c) {
          (*to[std::size_t(c)])[value.pos()] = clean_(component(*value, c), 1);
        }
      }
      if (first == 0) bricks_[3].push_back({origin, active(*leaf)});
    }
    add_tiles(tree, first, kComponents);
  }

  template <class Tree>
  void add_tiles(const Tree& tree, int first, int components) {
    auto it = tree.cbeginValueOn();
    it.setMaxDepth(Tree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; it; ++it) {
      const int edge = it.getDepth() == 0 ? 4096 : it.getDepth() == 1 ? 128 : kBrickEdge;
      const auto samples = std::uint64_t(edge) * std::uint64_t(edge) * std::uint64_t(edge);
      const openvdb::Coord o = it.getCoord();
      const Vec3i origin(o.x(), o.y(), o.z());
      for (int c = 0; c < components; ++c) {
        const float v = clean_(component(*it, c), samples);
        if (v != 0) tiles_[std::size_t(first + c)].push_back({origin, edge, v});
      }
      if (first == 0) tiles_[3].push_back({origin, edge, 1});
    }
  }
};

}  // namespace pvol::formats::detail
