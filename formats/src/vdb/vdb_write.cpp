// Fog volumes to OpenVDB files.
#include <fmt/format.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/memory.h"
#include "vdb/openvdb_start.h"
#include "vdb/vdb_calls.h"
#include "vdb/vdb_inspect.h"

namespace pvol::formats {

namespace {

using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

constexpr std::streamoff kUuidOffset = 8 + 4 + 4 + 4 + 1;  // after magic, versions and a flag

/// How many nodes of this edge, 1 << log2, hold the bricks.
std::uint64_t count_nodes(const std::vector<Brick>& bricks, int log2) {
  std::vector<std::array<int, 3>> nodes;
  for (const Brick& b : bricks) {
    const std::array<int, 3> at{b.origin.x >> log2, b.origin.y >> log2, b.origin.z >> log2};
    if (nodes.empty() || nodes.back() != at) nodes.push_back(at);
  }
  std::ranges::sort(nodes);
  return std::uint64_t(std::unique(nodes.begin(), nodes.end()) - nodes.begin());
}

/// What OpenVDB's tree of these bricks takes.
template <class Tree>
std::uint64_t tree_bytes(const std::vector<Brick>& bricks) {
  using Node = typename Tree::LeafNodeType;
  using Upper = typename Tree::RootNodeType::ChildNodeType;
  using Lower = typename Upper::ChildNodeType;
  constexpr std::uint64_t kOfHeap = 32;  // beside each leaf and its samples
  const std::uint64_t leaf = sizeof(Node) + Node::SIZE * sizeof(typename Tree::ValueType) + kOfHeap;
  return bricks.size() * leaf + count_nodes(bricks, Lower::TOTAL) * sizeof(Lower) +
         count_nodes(bricks, Upper::TOTAL) * sizeof(Upper);
}

void add_brick(FloatTree& tree, const Brick& brick) {
  const openvdb::Coord origin(brick.origin.x, brick.origin.y, brick.origin.z);
  auto* leaf = new Leaf(origin, 0.0f);
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
    if (brick.values[i] > 0) leaf->setValueOn(i, brick.values[i]);
  }
  tree.addLeaf(leaf);  // takes it over
}

openvdb::Index tile_level(const Tile& tile) {
  return tile.edge == 8 ? 1 : tile.edge == 128 ? 2 : 3;
}

/// The plainest map that fits: other programs handle uniform voxels best.
openvdb::math::MapBase::Ptr map(const Affine& a) {
  namespace om = openvdb::math;
  const openvdb::Vec3d scale(a.m[0].x, a.m[1].y, a.m[2].z), move(a.t.x, a.t.y, a.t.z);
  if (a == translation(a.t) * scaling({scale.x(), scale.y(), scale.z()})) {
    if (scale.x() == scale.y() && scale.x() == scale.z()) {
      return std::make_shared<om::UniformScaleTranslateMap>(scale.x(), move);
    }
    return std::make_shared<om::ScaleTranslateMap>(scale, move);
  }
  auto matrix = openvdb::Mat4d::identity();
  for (int c = 0; c < 3; ++c) {
    // OpenVDB multiplies row vectors from the left: the transpose.
    for (int r = 0; r < 3; ++r) matrix(c, r) = a.m[std::size_t(r)][c];
    matrix(3, c) = a.t[c];
  }
  return std::make_shared<om::AffineMap>(matrix);
}

/// A transform with exactly this map. Its constructor would simplify the map once more and lose
/// digits of the scale where the translation is large; reading one does not.
openvdb::math::Transform::Ptr transform(const VoxelGrid& grid) try {
  const openvdb::math::MapBase::Ptr m = map(grid.index_to_world);
  std::stringstream text;
  openvdb::io::setCurrentVersion(text);
  openvdb::writeString(text, m->type());
  m->write(text);
  auto result = std::make_shared<openvdb::math::Transform>();
  result->read(text);
  return result;
} catch (const openvdb::ArithmeticError&) {
  throw Error("grid '" + grid.name +
              "': OpenVDB rejects its map to the world, which is flat or has voxels below about "
              "1e-5; scale the world up");
}

openvdb::FloatGrid::Ptr fog_volume(const VoxelGrid& grid) {
  auto out = openvdb::FloatGrid::create(0.0f);
  for (const Brick& b : grid.bricks) add_brick(out->tree(), b);
  for (const Tile& t : grid.tiles) {
    out->tree().addTile(tile_level(t), {t.origin.x, t.origin.y, t.origin.z}, t.value, true);
  }
  out->setName(grid.name);
  out->setGridClass(openvdb::GRID_FOG_VOLUME);
  out->setTransform(transform(grid));
  return out;
}

openvdb::Vec3SGrid::Ptr color_grid(const ColorGrid& colors) {
  using Tree = openvdb::Vec3STree;
  auto out = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
  const auto color = [](const Float4& s) { return openvdb::Vec3s(s[0], s[1], s[2]); };
  visit_colors(colors, [&](Vec3i origin, int edge, std::span<const Float4> samples) {
    const openvdb::Coord o(origin.x, origin.y, origin.z);
    if (samples.size() == 1) {
      out->tree().addTile(tile_level({origin, edge, 1}), o, color(samples[0]), true);
      return;
    }
    auto* leaf = new Tree::LeafNodeType(o, openvdb::Vec3s(0.0f));
    for (openvdb::Index i = 0; i < Tree::LeafNodeType::SIZE; ++i) {
      if (samples[i][3] > 0) leaf->setValueOn(i, color(samples[i]));
    }
    out->tree().addLeaf(leaf);  // takes it over
  });
  out->setName(colors.name());
  out->setVectorType(openvdb::VEC_INVARIANT);  // placements do not turn colours
  out->setTransform(transform(colors.channels[0]));
  return out;
}

/// Component by component: first tiles, the large ones before those within them, then leaves, which
/// OpenVDB fills with the tile around them.
openvdb::Vec3SGrid::Ptr velocity_grid(const VelocityGrid& velocity) {
  auto out = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
  auto& tree = out->tree();
  for (const int edge : {4096, 128, kBrickEdge}) {
    for (int c = 0; c < 3; ++c) {
      for (const Tile& t : velocity.along[std::size_t(c)].tiles) {
        if (t.edge != edge) continue;
        const openvdb::Coord o(t.origin.x, t.origin.y, t.origin.z);
        openvdb::Vec3s v = tree.getValue(o);
        v[c] = t.value;
        tree.addTile(tile_level(t), o, v, true);
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    for (const Brick& b : velocity.along[std::size_t(c)].bricks) {
      auto* const leaf = tree.touchLeaf({b.origin.x, b.origin.y, b.origin.z});
      for (openvdb::Index i = 0; i < kBrickSamples; ++i) {
        if (b.values[i] == 0) continue;
        openvdb::Vec3s v = leaf->getValue(i);
        v[c] = b.values[i];
        leaf->setValueOn(i, v);
      }
    }
  }
  out->setName(velocity.along[0].name);
  out->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  out->setTransform(transform(velocity.along[0]));
  return out;
}

/// OpenVDB gives every file a random UUID; one made from the other bytes makes equal content equal
/// files, and different content still different ones.
void set_uuid(const std::filesystem::path& file) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  std::vector<char> bytes(std::size_t(1) << 20);
  XXH3_state_t* state = XXH3_createState();
  XXH3_128bits_reset(state);
  stream.seekg(kUuidOffset + 36);
  while (stream.read(bytes.data(), std::streamsize(bytes.size())), stream.gcount() > 0) {
    XXH3_128bits_update(state, bytes.data(), std::size_t(stream.gcount()));
  }
  const XXH128_hash_t hash = XXH3_128bits_digest(state);
  XXH3_freeState(state);
  const std::string uuid = fmt::format("{:08x}-{:04x}-{:04x}-{:04x}-{:012x}", hash.high64 >> 32,
                                       hash.high64 >> 16 & 0xffff, hash.high64 & 0xffff,
                                       hash.low64 >> 48, hash.low64 & 0xffffffffffffu);
  stream.clear();
  stream.seekp(kUuidOffset);
  stream.write(uuid.data(), std::streamsize(uuid.size()));
  if (!stream.flush()) throw Error("cannot write " + file.string());
}

}  // namespace

std::function<void(const std::filesystem::path& file)> detail::vdb_writer(
    const std::string& name, const std::vector<const VoxelGrid*>& grids,
    const std::vector<const ColorGrid*>& colors,
    const std::vector<const VelocityGrid*>& velocities) {
  // OpenVDB may crash where memory ends while a tree grows.
  constexpr std::uint64_t kBuffers = std::uint64_t{16} << 20;
  std::uint64_t bytes = kBuffers;
  for (const VoxelGrid* grid : grids) bytes += tree_bytes<FloatTree>(grid->bricks);
  for (const ColorGrid* grid : colors) {
    bytes += tree_bytes<openvdb::Vec3STree>(grid->channels[0].bricks);
  }
  for (const VelocityGrid* grid : velocities) {
    for (const VoxelGrid& g : grid->along) bytes += tree_bytes<openvdb::Vec3STree>(g.bricks);
  }
  require_memory(bytes, name + ": the tree of its grids");
  return [&](const std::filesystem::path& file) {
    detail::start_openvdb();
    openvdb::GridCPtrVec out;
    for (const VoxelGrid* grid : grids) out.push_back(fog_volume(*grid));
    for (const ColorGrid* grid : colors) out.push_back(color_grid(*grid));
    for (const VelocityGrid* grid : velocities) out.push_back(velocity_grid(*grid));
    openvdb::io::File to(file.string());
    to.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    to.write(out);
    to.close();
    // OpenVDB does not notice a full disk: what it wrote is inspected like any file.
    try {
      set_uuid(file);
      detail::ByteSource written(file);
      static_cast<void>(inspect_vdb(written));
    } catch (const std::exception&) {
      throw Error("it was not written completely; check that there is space on the disk");
    }
  };
}

}  // namespace pvol::formats
