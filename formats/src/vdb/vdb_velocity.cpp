// Vector grids, or three grids of numbers, as the components of velocities.
#include <fmt/format.h>

#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <deque>
#include <memory>
#include <span>
#include <string_view>

#include "file/grid_choice.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/velocity.h"
#include "vdb/vdb_load.h"

namespace pvol::formats {
namespace {

using detail::ByteSource;
using detail::VdbFile;
using detail::VdbGrid;

constexpr std::string_view kUsualNames[] = {"v", "vel", "velocity"};

using Samples = std::array<float, kBrickSamples>;

bool same(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

bool is_vector(const VdbGrid& grid) {
  return grid.type == "Tree_vec3s_5_4_3" || grid.type == "Tree_vec3d_5_4_3";
}
bool is_number(const VdbGrid& grid) {
  return grid.type == "Tree_float_5_4_3" || grid.type == "Tree_double_5_4_3";
}

const VdbGrid* find(const VdbFile& file, std::string_view name, bool (*fits)(const VdbGrid&)) {
  for (const VdbGrid& grid : file.grids) {
    if (fits(grid) && (same(grid.name, name) || same(grid.base, name))) return &grid;
  }
  return nullptr;
}

/// One grid of vectors, three of numbers, or none.
std::vector<const VdbGrid*> choose(const VdbFile& file, std::string_view name) {
  if (const VdbGrid* grid = find(file, name, is_vector)) return {grid};
  for (const char* between : {".", "_", ""}) {
    std::vector<const VdbGrid*> all;
    for (const char axis : {'x', 'y', 'z'}) {
      all.push_back(find(file, fmt::format("{}{}{}", name, between, axis), is_number));
    }
    if (std::find(all.begin(), all.end(), nullptr) == all.end()) return all;
  }
  return {};
}

/// Collects the values of trees as components of a velocity.
class Collector {
 public:
  std::uint64_t non_finite = 0;

  /// Component c of the tree's values is along axis first + c.
  template <class Tree>
  void add(const Tree& tree, int first) {
    constexpr int kComponents = openvdb::VecTraits<typename Tree::ValueType>::Size;
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
      std::array<Samples*, 3> to{};
      for (int c = 0; c < kComponents; ++c) {
        to[std::size_t(c)] = &samples_->emplace_back();
        to[std::size_t(c)]->fill(0);
        const openvdb::Coord o = leaf->origin();
        bricks_[std::size_t(first + c)].push_back(
            {{o.x(), o.y(), o.z()}, to[std::size_t(c)]->data()});
      }
      for (auto value = leaf->cbeginValueOn(); value; ++value) {
        for (int c = 0; c < kComponents; ++c) {
          (*to[std::size_t(c)])[value.pos()] = clean(component(*value, c), 1);
        }
      }
    }
    add_tiles(tree, first, kComponents);
  }

  [[nodiscard]] VelocityGrid take(const Affine& index_to_world, const std::string& name) && {
    VelocityGrid grid;
    for (std::size_t c = 0; c < 3; ++c) {
      grid.along[c].name = name;
      grid.along[c].index_to_world = index_to_world;
      grid.along[c].bricks = std::move(bricks_[c]);
      grid.along[c].tiles = std::move(tiles_[c]);
      grid.along[c].owner = samples_;
    }
    return grid;
  }

 private:
  std::shared_ptr<std::deque<Samples>> samples_ = std::make_shared<std::deque<Samples>>();
  std::array<std::vector<Brick>, 3> bricks_;
  std::array<std::vector<Tile>, 3> tiles_;

  template <class T>
  static float component(const T& value, int c) {
    if constexpr (openvdb::VecTraits<T>::IsVec) {
      return float(value[c]);
    } else {
      (void)c;
      return float(value);
    }
  }

  float clean(float v, std::uint64_t samples) {
    if (std::isfinite(v)) return v;
    non_finite += samples;
    return 0;
  }

  template <class Tree>
  void add_tiles(const Tree& tree, int first, int components) {
    auto it = tree.cbeginValueOn();
    it.setMaxDepth(Tree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; it; ++it) {
      const int edge = it.getDepth() == 0 ? 4096 : it.getDepth() == 1 ? 128 : kBrickEdge;
      const auto samples = std::uint64_t(edge) * std::uint64_t(edge) * std::uint64_t(edge);
      const openvdb::Coord o = it.getCoord();
      for (int c = 0; c < components; ++c) {
        const float v = clean(component(*it, c), samples);
        if (v != 0) tiles_[std::size_t(first + c)].push_back({{o.x(), o.y(), o.z()}, edge, v});
      }
    }
  }
};

void add_grid(const openvdb::GridBase::Ptr& grid, int axis, Collector& to) {
  if (const auto v = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) return to.add(v->tree(), axis);
  if (const auto v = openvdb::gridPtrCast<openvdb::Vec3DGrid>(grid)) return to.add(v->tree(), axis);
  if (const auto v = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return to.add(v->tree(), axis);
  to.add(openvdb::gridPtrCast<openvdb::DoubleGrid>(grid)->tree(), axis);
}

LoadedVelocity load(ByteSource& source, const VdbFile& file,
                    const std::vector<const VdbGrid*>& chosen, const std::string& name) {
  LoadedVelocity loaded;
  loaded.name = chosen.size() == 1 ? chosen.front()->name : name;
  Collector values;
  std::optional<Affine> map;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const openvdb::GridBase::Ptr grid = load_vdb_grid(source, file, *chosen[i]);
    const Affine own = detail::affine_map(source, *chosen[i], grid->transform());
    if (map && !(*map == own)) {
      throw Error(
          fmt::format("{}: the grids {} and {} lie on different lattices, as staggered "
                      "velocities do; resample them to one, or to a grid of vectors",
                      source.file().string(), chosen[0]->name, chosen[i]->name));
    }
    map = own;
    add_grid(grid, int(i), values);
  }
  if (chosen.front()->grid_class == "staggered") {
    loaded.warnings.push_back(
        "the velocities are staggered; they are taken as if they lay at the "
        "voxels' own places, half a voxel away");
  }
  if (values.non_finite > 0) {
    loaded.warnings.push_back(fmt::format(
        "{} components of velocities are not finite; they are taken as 0", values.non_finite));
  }
  loaded.grid = std::move(values).take(*map, loaded.name);
  return loaded;
}

}  // namespace

std::optional<LoadedVelocity> read_velocity(const std::filesystem::path& path,
                                            const std::string& name, bool strict) try {
  if (ending(path) != ".vdb") {
    throw Error(path.string() +
                ": velocities are read from .vdb files; name one with "
                "medium.motion.file");
  }
  ByteSource source(path);
  const VdbFile file = inspect_vdb(source);
  std::vector<const VdbGrid*> chosen;
  std::string base = name;
  if (!name.empty()) {
    chosen = choose(file, name);
    if (chosen.empty()) {
      throw Error(
          fmt::format("{}: no grid of vectors is called '{}', nor three of numbers '{}.x', "
                      "'{}.y' and '{}.z'; the file has: {}",
                      path.string(), name, name, name, name, detail::list_grids(choices(file))));
    }
  } else {
    for (const std::string_view usual : kUsualNames) {
      if (chosen.empty()) chosen = choose(file, base = usual);
    }
    if (chosen.empty()) return std::nullopt;
  }
  LoadedVelocity loaded = load(source, file, chosen, base);
  if (strict && !loaded.warnings.empty()) {
    throw Error(fmt::format("{}: grid '{}' is refused (strict): {}", path.string(), loaded.name,
                            loaded.warnings.front()));
  }
  return loaded;
} catch (const std::bad_alloc&) {
  throw Error(path.string() + ": not enough memory to load its velocities");
}

}  // namespace pvol::formats
