// The structure of a VDB tree of 5-4-3 layout in a file. Topology first, depth first: the root's
// tiles and children, then for each internal node its child mask, value mask and values, then its
// children; a leaf is its mask alone. The values of all leaves follow, each with its mask again.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <tuple>

#include "pvol/error.h"
#include "vdb/vdb_inspect.h"

namespace pvol::formats::detail {

namespace {

using Coord = std::array<std::int32_t, 3>;
using LeafMask = std::array<std::uint64_t, 8>;

constexpr int kUpper = 2;  // level of the root's children; the nodes below are 1, leaves 0
constexpr std::size_t kEntries[] = {512, 4096, 32768};       // of a node of each level
constexpr std::uint64_t kTileVolume[] = {1, 512, 1u << 21};  // of one entry
constexpr std::uint64_t kRootTileVolume = std::uint64_t(1) << 36;
constexpr std::int32_t kRootTileEdge = 4096;

/// How values are stored.
struct ValueLayout {
  std::size_t bytes = 0;         ///< in backgrounds and tiles of the root
  std::size_t stored_bytes = 0;  ///< in arrays: less where they are halves
  bool halves = false;
};

ValueLayout value_layout(const VdbGrid& grid) {
  struct Known {
    const char* type;
    std::size_t numbers, size;
    bool real;
  };
  constexpr Known kKnown[] = {{"Tree_float_5_4_3", 1, 4, true},  {"Tree_double_5_4_3", 1, 8, true},
                              {"Tree_vec3s_5_4_3", 3, 4, true},  {"Tree_vec3d_5_4_3", 3, 8, true},
                              {"Tree_vec3i_5_4_3", 3, 4, false}, {"Tree_int32_5_4_3", 1, 4, false},
                              {"Tree_int64_5_4_3", 1, 8, false}};
  for (const Known& k : kKnown) {
    if (grid.type != k.type) continue;
    const bool halves = grid.half && k.real;
    return {k.numbers * k.size, k.numbers * (halves ? 2 : k.size), halves};
  }
  return {};
}

template <std::size_t N>
std::size_t count_on(const std::array<std::uint64_t, N>& mask) {
  std::size_t on = 0;
  for (const std::uint64_t word : mask) on += std::size_t(std::popcount(word));
  return on;
}

/// Walks one tree; `cursor` is where the walk has come to.
struct TreeWalk {
  ByteCursor cursor;
  ValueLayout layout;
  std::uint32_t compression = 0;
  std::uint64_t active_voxels = 0;
  std::array<std::uint64_t, 3> nodes{};             // by level
  std::map<Coord, std::vector<LeafMask>> leaves{};  // by child of the root, in the order of values

  template <std::size_t N>
  std::array<std::uint64_t, N> mask() {
    std::array<std::uint64_t, N> m;
    std::memcpy(m.data(), cursor.bytes(N * 8), N * 8);
    return m;
  }

  void root();
  template <int kLevel>
  void node(std::vector<LeafMask>& masks);
  void all_leaf_values();
  void values(std::size_t active, std::size_t entries);
  void payload(std::size_t count);
};

/// An array of `count` values: compressed with its size before it, or plain. A wrong size would
/// make OpenVDB write past its buffer.
void TreeWalk::payload(std::size_t count) {
  const std::uint64_t expected = count * layout.stored_bytes;
  if (layout.halves && count == 0) return;
  if (!(compression & (kVdbZip | kVdbBlosc))) return cursor.skip(expected);
  const auto size = cursor.value<std::int64_t>();
  if (size <= 0) {
    // Minus the size of an array that did not get smaller.
    if (0 - std::uint64_t(size) != expected) {
      cursor.fail(fmt::format("an array of a wrong size ({} instead of -{}); the file is damaged",
                              size, expected));
    }
    return cursor.skip(expected);
  }
  constexpr std::int64_t kBloscHeader = 16;
  if (compression & kVdbBlosc) {
    std::uint32_t bytes[4] = {};  // versions and flags, plain size, block size, compressed size
    if (size >= kBloscHeader) std::memcpy(bytes, cursor.bytes(kBloscHeader), sizeof bytes);
    if (bytes[1] != expected || bytes[3] != std::uint64_t(size)) {
      cursor.fail("a compressed array whose size is wrong; the file is damaged");
    }
    return cursor.skip(std::uint64_t(size - kBloscHeader));
  }
  cursor.skip(std::uint64_t(size));
}

/// The values of one node. With masked compression the inactive ones are left out where one or two
/// values, given before, and a mask to choose between them restore them.
void TreeWalk::values(std::size_t active, std::size_t entries) {
  const auto mode = cursor.value<std::uint8_t>();
  constexpr std::uint8_t kOneInactive = 2, kMask = 3, kMaskAndOne = 4, kMaskAndTwo = 5, kAll = 6;
  if (mode > kAll) {
    cursor.fail(
        fmt::format("inactive values stored in an unknown way ({}); the file is damaged", mode));
  }
  if (mode == kOneInactive || mode == kMaskAndOne) cursor.skip(layout.bytes);
  if (mode == kMaskAndTwo) cursor.skip(2 * layout.bytes);
  if (mode >= kMask && mode <= kMaskAndTwo) cursor.skip(entries / 8);
  payload((compression & kVdbActiveMask) && mode != kAll ? active : entries);
}

template <int kLevel>
void TreeWalk::node(std::vector<LeafMask>& masks) {
  ++nodes[kLevel];
  if constexpr (kLevel == 0) {
    masks.push_back(mask<8>());
    active_voxels += count_on(masks.back());
  } else {
    constexpr std::size_t kWords = kEntries[kLevel] / 64;
    const auto children = mask<kWords>();
    const auto active = mask<kWords>();
    for (std::size_t w = 0; w < kWords; ++w) {
      if (children[w] & active[w]) {
        cursor.fail("a node with a child where it has an active value; the file is damaged");
      }
    }
    values(count_on(active), kEntries[kLevel]);
    active_voxels += count_on(active) * kTileVolume[kLevel];
    for (std::size_t n = count_on(children); n > 0; --n) node<kLevel - 1>(masks);
  }
}

void TreeWalk::root() {
  if (cursor.value<std::uint32_t>() != 1) cursor.fail("several buffers; the file is damaged");
  cursor.skip(layout.bytes);  // background
  const auto tiles = cursor.value<std::uint32_t>(), children = cursor.value<std::uint32_t>();
  std::map<Coord, bool> is_child;
  for (std::uint64_t i = 0; i < std::uint64_t(tiles) + children; ++i) {
    Coord origin;
    std::memcpy(origin.data(), cursor.bytes(sizeof origin), sizeof origin);
    const bool aligned = std::all_of(origin.begin(), origin.end(),
                                     [](std::int32_t x) { return x % kRootTileEdge == 0; });
    if (!aligned || !is_child.emplace(origin, i >= tiles).second) {
      cursor.fail("an entry of the root that is misplaced or double; the file is damaged");
    }
    if (i >= tiles) {
      node<kUpper>(leaves[origin]);
      continue;
    }
    cursor.skip(layout.bytes);
    const auto active = cursor.value<std::uint8_t>();
    if (active > 1) cursor.fail("a tile neither active nor inactive; the file is damaged");
    active_voxels += active * kRootTileVolume;
  }
}

void TreeWalk::all_leaf_values() {
  for (const auto& [origin, masks] : leaves) {
    for (const LeafMask& m : masks) {
      if (mask<8>() != m) {
        cursor.fail("a leaf whose two masks differ; the file is damaged");
      }
      values(count_on(m), kEntries[0]);
    }
  }
}

/// Values and masks of nodes in memory: a leaf has one mask, other nodes two, and room for a
/// pointer in place of each value. Halves are floats there.
std::uint64_t bytes_of_nodes(const std::array<std::uint64_t, 3>& nodes, const ValueLayout& layout) {
  constexpr std::uint64_t kOther = 64;  // what a node has besides, and what its allocation takes
  const std::uint64_t entry = std::max<std::uint64_t>(sizeof(void*), layout.bytes);
  std::uint64_t bytes = nodes[0] * (kEntries[0] * layout.bytes + kEntries[0] / 8 + 2 * kOther);
  for (const std::size_t level : {1, 2}) {
    bytes += nodes[level] * (kEntries[level] * entry + kEntries[level] / 4 + kOther);
  }
  return bytes;
}

}  // namespace

VdbTreeSize check_vdb_tree(ByteSource& source, const VdbGrid& grid, std::uint64_t limit) {
  TreeWalk walk{ByteCursor(source, {grid.tree.begin, limit}, "grid '" + printable(grid.name) + "'"),
                value_layout(grid), grid.compression};
  ByteCursor& cursor = walk.cursor;
  if (walk.layout.bytes == 0) {
    cursor.fail("a tree of type '" + printable(grid.type) +
                "', whose end cannot be found in a file without offsets; save it with offsets");
  }
  walk.root();
  if (grid.values && cursor.position() != *grid.values) {
    cursor.fail(fmt::format(
        "the tree ends here, but its values begin at byte {}; the file is damaged", *grid.values));
  }
  walk.all_leaf_values();
  if (grid.voxel_count && walk.active_voxels != *grid.voxel_count) {
    cursor.fail(fmt::format(
        "{} active voxels instead of {}, the number in its metadata; the file is damaged",
        walk.active_voxels, *grid.voxel_count));
  }
  return {cursor.position(), walk.active_voxels, bytes_of_nodes(walk.nodes, walk.layout)};
}

}  // namespace pvol::formats::detail
