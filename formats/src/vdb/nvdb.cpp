// NanoVDB files. Such a file is a copy of memory: nodes refer to each other by byte offsets. So
// every offset is checked before it is followed, sizes are checked before memory is taken, and the
// values are copied into bricks of our own. NanoVDB's headers give the layout of its nodes, nothing
// else.
#include <fmt/format.h>

#include <nanovdb/NanoVDB.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "file/density_values.h"
#include "pvol/error.h"
#include "vdb/nvdb_checksum.h"
#include "vdb/nvdb_file.h"

namespace pvol::formats {

namespace {

using detail::ByteSource;
using detail::NvdbGrid;
using detail::NvdbMemory;
using detail::NvdbNode;
using detail::ValueCounts;

/// Copies the densities of one grid; T is NanoVDB's name for the kind of values.
template <class T>
class TreeCopy {
 public:
  TreeCopy(const NvdbMemory& memory, VoxelGrid& grid) : memory_(memory), grid_(grid) {}

  void run() {
    const auto& tree = memory_.at<nanovdb::TreeData<>>(kTree);
    const std::uint64_t offset = kTree + tree.mNodeOffset[3];
    const auto& root = memory_.at<Root>(offset);
    background_ = float(root.mBackground);
    static_cast<void>(memory_.at<Root>(offset, root.mTableSize * sizeof(typename Root::Tile)));
    check_head(memory_, offset + sizeof(Root) + root.mTableSize * sizeof(typename Root::Tile));
    std::set<std::tuple<int, int, int>> seen;
    for (std::uint32_t i = 0; i < root.mTableSize; ++i) {
      const auto& tile = *root.tile(i);
      const nanovdb::Coord o = tile.origin();
      const Vec3i origin{o[0], o[1], o[2]};
      if (!seen.emplace(o[0], o[1], o[2]).second || o[0] % kEdge || o[1] % kEdge || o[2] % kEdge) {
        memory_.fail("an entry of the root is misplaced or double");
      }
      if (tile.child != 0) {
        upper(offset + std::uint64_t(tile.child), origin);
      } else {
        value(float(tile.value), tile.state != 0, origin, kEdge);
      }
    }
    check_nodes(memory_, nodes_);
    if (tree.mVoxelCount != 0 && counts_.active != tree.mVoxelCount) {
      memory_.fail(fmt::format("{} active voxels instead of {}", counts_.active, tree.mVoxelCount));
    }
    if (background_ > 0 && mirrored_) {
      throw Error(memory_.where +
                  "it is a level set, though not marked as one (its empty space holds a value "
                  "outside and minus that inside); convert it to a fog volume first");
    }
    finish();
  }

  [[nodiscard]] const ValueCounts& counts() const { return counts_; }
  [[nodiscard]] float background() const { return background_; }

 private:
  using Leaf = typename nanovdb::NanoLeaf<T>::DataType;
  using Lower = typename nanovdb::NanoLower<T>::DataType;
  using Upper = typename nanovdb::NanoUpper<T>::DataType;
  using Root = typename nanovdb::NanoRoot<T>::DataType;
  static constexpr std::uint64_t kTree = sizeof(nanovdb::GridData);
  static constexpr int kEdge = 4096, kUpperEdge = 128;  // of entries of the root and of upper nodes

  /// Lists a node: more than fit into the grid would be nodes with several parents.
  template <class Node>
  const Node& visit(std::vector<NvdbNode>& nodes, std::uint64_t offset) {
    const Node& node = memory_.at<Node>(offset);
    nodes.push_back({offset, sizeof(Node), sizeof(Node)});
    if (nodes.size() > memory_.size / sizeof(Node)) memory_.fail("nodes have several parents");
    return node;
  }

  void value(float v, bool active, Vec3i origin, int edge) {
    const std::uint64_t samples = std::uint64_t(edge) * std::uint64_t(edge) * std::uint64_t(edge);
    if (active) {
      const float density = detail::to_density(v, samples, counts_);
      if (density > 0) grid_.tiles.push_back({origin, edge, density});
    } else {
      if (detail::is_stray(v, background_)) counts_.stray += samples;
      mirrored_ |= v == -background_;
    }
  }

  /// Entries of an internal node, `kEdge` voxels wide each; `child` gets offsets and origins.
  template <int kEntryEdge, int kLog2, class Node, class Child>
  void entries(const Node& node, std::uint64_t offset, Vec3i origin, Child child) {
    constexpr std::uint32_t kMask = (1u << kLog2) - 1;
    for (std::uint32_t n = 0; n < 1u << (3 * kLog2); ++n) {
      const Vec3i at =
          origin +
          Vec3i(int(n >> (2 * kLog2)), int(n >> kLog2 & kMask), int(n & kMask)) * kEntryEdge;
      if (node.mChildMask.isOn(n)) {
        child(offset + std::uint64_t(node.mTable[n].child), at);
      } else {
        value(float(node.mTable[n].value), node.mValueMask.isOn(n), at, kEntryEdge);
      }
    }
  }

  void upper(std::uint64_t offset, Vec3i origin) {
    entries<kUpperEdge, 5>(visit<Upper>(nodes_[0], offset), offset, origin,
                           [this](std::uint64_t to, Vec3i at) { lower(to, at); });
  }

  void lower(std::uint64_t offset, Vec3i origin) {
    entries<kBrickEdge, 4>(visit<Lower>(nodes_[1], offset), offset, origin,
                           [this](std::uint64_t to, Vec3i at) { leaf(to, at); });
  }

  void leaf(std::uint64_t offset, Vec3i origin) {
    const Leaf& node = visit<Leaf>(nodes_[2], offset);
    if constexpr (!Leaf::FIXED_SIZE) {
      constexpr int kMostBits = 4;  // 2^4
      if (node.mFlags >> 5 > kMostBits) memory_.fail("a leaf of unknown precision");
      nodes_[2].back().size = node.memUsage();
      static_cast<void>(memory_.at<Leaf>(offset, node.memUsage() - sizeof(Leaf)));
    }
    const std::size_t start = values_.size();
    values_.resize(start + kBrickSamples);
    float largest = 0;
    for (std::uint32_t i = 0; i < kBrickSamples; ++i) {
      const auto v = float(node.getValue(i));
      if (node.mValueMask.isOn(i)) {
        values_[start + i] = detail::to_density(v, 1, counts_);
        largest = std::max(largest, values_[start + i]);
      } else {
        counts_.stray += detail::is_stray(v, background_);
        mirrored_ |= v == -background_;
      }
    }
    if (largest > 0) {
      origins_.push_back(origin);
    } else {
      values_.resize(start);
    }
  }

  /// Hands the values over, now that they do not move any more.
  void finish() {
    auto owner = std::make_shared<std::vector<float>>(std::move(values_));
    for (std::size_t i = 0; i < origins_.size(); ++i) {
      grid_.bricks.push_back({origins_[i], owner->data() + i * kBrickSamples});
    }
    grid_.owner = owner;
    sort(grid_);
  }

  const NvdbMemory& memory_;
  VoxelGrid& grid_;
  ValueCounts counts_;
  float background_ = 0;
  bool mirrored_ = false;  // an inactive sample is -background
  detail::NvdbLevels nodes_;
  std::vector<float> values_;
  std::vector<Vec3i> origins_;
};

Affine affine_map(const NvdbMemory& memory, const nanovdb::GridData& head) {
  const double* m = head.mMap.mMatD;
  Affine a;
  a.m = {Vec3d{m[0], m[1], m[2]}, Vec3d{m[3], m[4], m[5]}, Vec3d{m[6], m[7], m[8]}};
  a.t = {head.mMap.mVecD[0], head.mMap.mVecD[1], head.mMap.mVecD[2]};
  const Affine back = inverse(a);
  bool usable = is_finite(a.t) && is_finite(back.t);
  for (std::size_t r = 0; r < 3; ++r) usable &= is_finite(a.m[r]) && is_finite(back.m[r]);
  if (!usable) memory.fail("its map to the world is not finite or has no inverse");
  return a;
}

template <class T>
void copy_grid(const NvdbMemory& memory, const GridOptions& options, const ByteSource& source,
               LoadedGrid& loaded) {
  TreeCopy<T> copy(memory, loaded.grid);
  copy.run();
  finish_report(source.file(), copy.counts(), copy.background(), options.strict, loaded.report);
}

}  // namespace

std::vector<GridEntry> list_nvdb(const std::filesystem::path& file) {
  ByteSource source(file);
  return detail::entries_of(choices(inspect_nvdb(source)));
}

LoadedGrid read_nvdb(const std::filesystem::path& file, const GridOptions& options) try {
  ByteSource source(file);
  const std::vector<NvdbGrid> grids = inspect_nvdb(source);
  LoadedGrid loaded;
  const std::vector<detail::GridChoice> list = choices(grids);
  const NvdbGrid& chosen = grids[choose_grid(file, list, options.grid, loaded.report.warnings)];
  loaded.report.grid = chosen.name;
  loaded.report.type = detail::nvdb_type(chosen.type);
  if (!chosen.base.empty()) loaded.grid.name = chosen.base;

  const NvdbMemory memory = decode_nvdb(source, chosen);
  const auto& head = memory.at<nanovdb::GridData>(0);
  if (head.mMagic != NANOVDB_MAGIC_NUMBER || head.mGridType != chosen.type ||
      head.mGridClass != chosen.grid_class || head.mGridSize > memory.size) {
    memory.fail("its head does not match the list of grids");
  }
  loaded.grid.index_to_world = affine_map(memory, head);
  using nanovdb::GridType;
  switch (chosen.type) {
    case GridType::Double:
      copy_grid<double>(memory, options, source, loaded);
      break;
    case GridType::Fp4:
      copy_grid<nanovdb::Fp4>(memory, options, source, loaded);
      break;
    case GridType::Fp8:
      copy_grid<nanovdb::Fp8>(memory, options, source, loaded);
      break;
    case GridType::Fp16:
      copy_grid<nanovdb::Fp16>(memory, options, source, loaded);
      break;
    case GridType::FpN:
      copy_grid<nanovdb::FpN>(memory, options, source, loaded);
      break;
    default:
      copy_grid<float>(memory, options, source, loaded);
  }
  detail::warn_of_others(list, options, loaded.report);
  return loaded;
} catch (const std::bad_alloc&) {
  throw Error(file.string() + ": not enough memory to load it");
}

}  // namespace pvol::formats
