// Files made here: what is written is read, and damage is refused.
#include "pvol/formats/vdb.h"

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <cstring>
#include <random>

#include "pvol/error.h"
#include "pvol/formats/memory.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"
#include "support/vdb_files.h"
#include "vdb/vdb_load.h"

namespace pvol::formats {
namespace vdb_test {

namespace fs = std::filesystem;
using test::all;
using test::refusal;
using test::SampleFinder;

std::uint64_t samples_of(const VoxelGrid& g) {
  std::uint64_t n = g.bricks.size() * kBrickSamples;
  for (const Tile& t : g.tiles)
    n += std::uint64_t(t.edge) * std::uint64_t(t.edge) * std::uint64_t(t.edge);
  return n;
}

/// Bricks and tiles in order, as values.
std::string content(const VoxelGrid& g) {
  std::string bytes;
  for (const Brick& b : g.bricks) {
    bytes.append(reinterpret_cast<const char*>(&b.origin), sizeof b.origin);
    bytes.append(reinterpret_cast<const char*>(b.values), kBrickSamples * sizeof(float));
  }
  for (const Tile& t : g.tiles) bytes.append(reinterpret_cast<const char*>(&t), sizeof t);
  return bytes;
}

constexpr Affine kSheared = {{Vec3d{0.5, 0.1, 0}, Vec3d{0, -2, 0.3}, Vec3d{0.25, 0, 1}},
                             {7, -8, 9}};

/// A grid with bricks of noise, part of them empty, that owns its values.
VoxelGrid noise_grid(const std::vector<Vec3i>& origins, unsigned seed) {
  auto values = std::make_shared<std::vector<float>>(origins.size() * kBrickSamples);
  std::mt19937 random(seed);
  for (float& v : *values) v = random() % 3 ? float(random() % 1000 + 1) / 1000 : 0.0f;
  VoxelGrid grid;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    grid.bricks.push_back({origins[i], values->data() + i * kBrickSamples});
  }
  grid.owner = values;
  grid.index_to_world = kSheared;
  return grid;
}

VoxelGrid small_grid() {
  VoxelGrid grid = noise_grid({{0, 0, 0}, {8, 0, 0}, {-8, 16, 4096}, {-4096, -8, 0}}, 3);
  grid.tiles = {{{8, 8, 8}, 8, 0.5f}, {{128, 128, 0}, 128, 0.25f}, {{8192, 0, -4096}, 4096, 2}};
  return grid;
}

TEST(VoxelGrid, TilesMayEndAtTheLastCoordinate) {
  constexpr int kLast = 2147483647;
  VoxelGrid grid;
  grid.tiles = {{{kLast - 4095, kLast - 4095, kLast - 4095}, 4096, 2}};
  EXPECT_EQ(sample(grid, {kLast, kLast, kLast}), 2);
  EXPECT_EQ(sample(grid, {kLast, kLast, kLast - 4096}), 0);
  EXPECT_EQ(sample(grid, {-kLast - 1, kLast, kLast}), 0);
}

TEST(VoxelGrid, SortingOrdersByXThenYThenZ) {
  VoxelGrid grid = noise_grid({{8, 0, 0}, {0, 8, 0}, {0, 0, 8}, {-8, 8, 8}, {0, 0, 0}}, 1);
  sort(grid);
  const Vec3i want[] = {{-8, 8, 8}, {0, 0, 0}, {0, 0, 8}, {0, 8, 0}, {8, 0, 0}};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(grid.bricks[i].origin, want[i]);
}

/// Of trees with few and with many leaves in a node, as OpenVDB counts it.
TEST(Vdb, TheMemoryOfATreeIsKnownBeforeItIsRead) {
  const TemporaryFolder folder;
  std::vector<Vec3i> near, far;
  for (int i = 0; i < 600; ++i) {
    near.push_back(Vec3i(i % 10, i / 10 % 10, i / 100) * 8);
    far.push_back(Vec3i(i % 10, i / 10 % 10, i / 100) * 1024);
  }
  for (const VoxelGrid& grid : {noise_grid(near, 1), noise_grid(far, 2), small_grid()}) {
    const fs::path file = folder.file("a.vdb");
    write_vdb(file, {&grid});
    detail::ByteSource source(file);
    const detail::VdbFile found = detail::inspect_vdb(source);
    const auto& tree = found.grids.at(0);
    const double told = double(detail::check_vdb_tree(source, tree, tree.tree.end).memory);
    const double used = double(detail::load_vdb_grid(source, found, tree)->memUsage());
    EXPECT_GT(told, 0.99 * used);
    EXPECT_LT(told, 1.1 * used);
  }
}

TEST(Memory, MoreThanThereIsIsRefused) {
  EXPECT_NO_THROW(require_memory(0, "nothing"));
  const std::string error = test::error_of([] { require_memory(1ull << 60, "all"); });
  EXPECT_TRUE(says(error, "vdb.more_memory_than_machine"));
}

TEST(Vdb, WrittenGridsReadBackTheSame) {
  const TemporaryFolder folder;
  VoxelGrid grid = small_grid();
  grid.name = "smoke";
  write_vdb(folder.file("a.vdb"), {&grid});
  sort(grid);
  const LoadedGrid got = read_vdb(folder.file("a.vdb"));
  EXPECT_EQ(content(got.grid), content(grid));
  EXPECT_EQ(got.grid.name, "smoke");
  EXPECT_EQ(got.report.grid, "smoke");
  EXPECT_EQ(got.report.type, "float");
  EXPECT_TRUE(got.report.warnings.empty()) << all(got.report.warnings);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_DOUBLE_EQ(got.grid.index_to_world.m[std::size_t(r)][c], kSheared.m[std::size_t(r)][c]);
    }
  }
  EXPECT_EQ(got.grid.index_to_world.t, kSheared.t);
}

TEST(Vdb, OneVoxelAndNoVoxelReadBack) {
  const TemporaryFolder folder;
  auto values = std::make_shared<std::vector<float>>(kBrickSamples);
  (*values)[(1 * 8 + 2) * 8 + 3] = 4;
  VoxelGrid one;
  one.bricks = {{{-8, 0, 16}, values->data()}};
  one.owner = values;
  write_vdb(folder.file("one.vdb"), {&one});
  const LoadedGrid got = read_vdb(folder.file("one.vdb"));
  EXPECT_EQ(got.report.active, 1u);
  EXPECT_EQ(samples_of(got.grid), 512u);
  EXPECT_EQ(sample(got.grid, {-7, 2, 19}), 4);
  EXPECT_EQ(sample(got.grid, {-7, 2, 18}), 0);

  const VoxelGrid none;
  write_vdb(folder.file("none.vdb"), {&none});
  const LoadedGrid empty = read_vdb(folder.file("none.vdb"));
  EXPECT_EQ(samples_of(empty.grid), 0u);
  EXPECT_TRUE(says(all(empty.report.warnings), "vdb.empty"));
}

TEST(Vdb, DiagonalMapsOfAnySizeReadBackExactly) {
  const TemporaryFolder folder;
  VoxelGrid grid = noise_grid({{0, 0, 0}}, 1);
  for (const Vec3d size : {Vec3d{1, 1, 1}, Vec3d{0.1, 0.1, 0.1}, Vec3d{1e-4, 1e-4, 1e-4},
                           Vec3d{1e9, 1e9, 1e9}, Vec3d{-1, 2, 3}}) {
    grid.index_to_world = translation({3, -1e8, 0}) * scaling(size);
    write_vdb(folder.file("a.vdb"), {&grid});
    EXPECT_EQ(read_vdb(folder.file("a.vdb")).grid.index_to_world, grid.index_to_world) << size.x;
  }
}

TEST(Vdb, MapsThatFlattenSpaceAreRefusedOnBothSides) {
  const TemporaryFolder folder;
  VoxelGrid grid = noise_grid({{0, 0, 0}}, 1);
  grid.index_to_world = scaling({1, 0, 1});
  EXPECT_THROW(write_vdb(folder.file("flat.vdb"), {&grid}), Error);
  EXPECT_FALSE(fs::exists(folder.file("flat.vdb")));

  grid.index_to_world = {};
  write_vdb(folder.file("a.vdb"), {&grid});
  std::string bytes = read_bytes(folder.file("a.vdb"));
  const std::string type = "UniformScaleTranslateMap";
  const std::size_t map = bytes.find(type) + type.size() + 24;  // after the translation
  for (const double bad : {0.0, std::nan(""), HUGE_VAL}) {
    std::memcpy(bytes.data() + map, &bad, 8);  // the scale along x
    write_bytes(folder.file("b.vdb"), bytes);
    EXPECT_TRUE(says(refusal(folder.file("b.vdb")), "vdb.map_world_not_finite")) << bad;
  }
  for (const double good : {1e-9, 1e-30, 1e30}) {  // OpenVDB itself makes no such maps
    for (int axis = 0; axis < 3; ++axis) std::memcpy(bytes.data() + map + 8 * axis, &good, 8);
    write_bytes(folder.file("b.vdb"), bytes);
    EXPECT_EQ(read_vdb(folder.file("b.vdb")).grid.index_to_world, scaling(Vec3d{good}));
  }
  grid.index_to_world = scaling(Vec3d{1e-9});
  EXPECT_THROW(write_vdb(folder.file("tiny.vdb"), {&grid}), Error);
}

TEST(Vdb, EqualGridsMakeEqualFiles) {
  const TemporaryFolder folder;
  VoxelGrid grid = small_grid();
  write_vdb(folder.file("a.vdb"), {&grid});
  std::reverse(grid.bricks.begin(), grid.bricks.end());
  write_vdb(folder.file("b.vdb"), {&grid});
  EXPECT_EQ(read_bytes(folder.file("a.vdb")), read_bytes(folder.file("b.vdb")));
  grid.tiles[0].value *= 2;
  write_vdb(folder.file("c.vdb"), {&grid});
  EXPECT_NE(read_bytes(folder.file("a.vdb")).substr(21, 36),
            read_bytes(folder.file("c.vdb")).substr(21, 36));
}

TEST(Vdb, SeveralGridsAreFoundByName) {
  const TemporaryFolder folder;
  VoxelGrid a = noise_grid({{0, 0, 0}}, 1), b = noise_grid({{0, 0, 0}}, 2);
  a.name = "density";
  b.name = "majorant";
  write_vdb(folder.file("two.vdb"), {&b, &a});
  const fs::path two = folder.file("two.vdb");
  EXPECT_EQ(content(read_vdb(two).grid), content(a));
  EXPECT_EQ(content(read_vdb(two, {"majorant", false}).grid), content(b));
  EXPECT_TRUE(says(refusal(two, {"minorant", false}), "vdb.no_grid_called_minorant"));
  a.name = "minorant";
  write_vdb(folder.file("none.vdb"), {&b, &a});
  EXPECT_TRUE(says(refusal(folder.file("none.vdb")), "vdb.no_grid_called_density_several_hold"));

  a.name = b.name = "density";
  write_vdb(folder.file("same.vdb"), {&b, &a});
  const fs::path same = folder.file("same.vdb");
  EXPECT_EQ(content(read_vdb(same).grid), content(b));
  EXPECT_EQ(content(read_vdb(same, {"density[1]", false}).grid), content(a));
  EXPECT_EQ(read_vdb(same, {"density[1]", false}).grid.name, "density");
  EXPECT_FALSE(refusal(same, {"density[2]", false}).empty());
  EXPECT_FALSE(refusal(same, {"", true}).empty());
}

TEST(Vdb, FoldersThatCannotBeWrittenAreErrorsAndFilesStayAsTheyWere) {
  const TemporaryFolder folder;
  const VoxelGrid grid = small_grid();
  EXPECT_THROW(write_vdb(folder.file("absent") / "a.vdb", {&grid}), Error);
  EXPECT_TRUE(says(refusal(folder.file("absent.vdb")), "vdb.open_absent_vdb"));
  EXPECT_TRUE(says(refusal(folder.file("")), "vdb.read_expected_regular"));
}

openvdb::FloatGrid::Ptr open_grid(const std::string& name, float background = 0) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(background);
  grid->setName(name);
  std::mt19937 random(5);
  for (int i = 0; i < 900; ++i) {
    grid->tree().setValue({int(random() % 40) - 20, int(random() % 20), int(random() % 9)},
                          float(random() % 4096 + 1) / 1024);
  }
  return grid;
}

void write_open(const fs::path& file, const openvdb::GridPtrVec& grids, std::uint32_t compression) {
  openvdb::io::File out(file.string());
  out.setCompression(compression);
  out.write(grids);
  out.close();
}

constexpr std::uint32_t kCompressions[] = {
    openvdb::io::COMPRESS_NONE,  openvdb::io::COMPRESS_ACTIVE_MASK,
    openvdb::io::COMPRESS_ZIP,   openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK,
    openvdb::io::COMPRESS_BLOSC, openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK};

TEST(Vdb, EveryCompressionAndPrecisionLoadsTheSameValues) {
  const TemporaryFolder folder;
  const auto grid = open_grid("density");
  grid->tree().addTile(1, {80, 0, 0}, 0.5f, true);
  grid->tree().addTile(1, {88, 0, 0}, 0.75f, false);  // stray
  grid->tree().addTile(3, {4096, 4096, 0}, 0.75f, true);
  grid->tree().setValueOff({-20, 0, 0}, 3);  // strays of several values
  grid->tree().setValueOff({-20, 0, 1}, -3);
  grid->tree().setValueOff({0, 1, 0}, 5);
  for (const std::uint32_t compression : kCompressions) {
    for (const bool half : {false, true}) {
      SCOPED_TRACE(std::to_string(compression) + (half ? " half" : ""));
      grid->setSaveFloatAsHalf(half);
      write_open(folder.file("a.vdb"), {grid}, compression);
      const LoadedGrid got = read_vdb(folder.file("a.vdb"));
      EXPECT_EQ(got.report.type, half ? "half" : "float");
      EXPECT_EQ(got.report.active, grid->activeVoxelCount());
      EXPECT_TRUE(says(all(got.report.warnings), "vdb.inactive_voxels_hold_values"));
      const SampleFinder lookup(got.grid);
      const auto accessor = grid->getConstAccessor();
      for (int x = -24; x < 100; ++x) {
        for (int y = -4; y < 24; ++y) {
          for (int z = -4; z < 14; ++z) {
            const openvdb::Coord c(x, y, z);
            const float want = accessor.isValueOn(c) ? accessor.getValue(c) : 0;
            ASSERT_NEAR(lookup({x, y, z}), want, half ? 4e-3f : 0.0f) << c;
          }
        }
      }
    }
  }
}

TEST(Vdb, StreamsOfSeveralGridsAndSharedTreesLoad) {
  const TemporaryFolder folder;
  const auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("v");
  velocity->tree().setValue({1, 2, 3}, openvdb::Vec3f(1, 2, 3));
  const auto density = open_grid("density");
  const auto shared = openvdb::FloatGrid::create(density->treePtr());  // one tree, two maps
  shared->setName("shared");
  shared->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
  const openvdb::GridPtrVec grids = {velocity, density, shared};
  write_open(folder.file("file.vdb"), grids, openvdb::io::COMPRESS_BLOSC);
  std::ofstream out(folder.file("stream.vdb"), std::ios::binary);
  openvdb::io::Stream(out).write(grids);
  out.close();

  for (const char* file : {"file.vdb", "stream.vdb"}) {
    SCOPED_TRACE(file);
    const LoadedGrid first = read_vdb(folder.file(file));
    const LoadedGrid second = read_vdb(folder.file(file), {"shared", false});
    EXPECT_EQ(first.report.active, density->activeVoxelCount());
    EXPECT_EQ(content(first.grid), content(second.grid));
    EXPECT_EQ(first.grid.index_to_world, Affine{});
    EXPECT_EQ(second.grid.index_to_world, scaling({0.25, 0.25, 0.25}));
  }
  // A first tree of a type that pvol does not know.
  std::string bytes = read_bytes(folder.file("stream.vdb"));
  bytes.replace(bytes.find("Tree_vec3s_5_4_3"), 16, "Tree_vec4s_5_4_3");
  std::ofstream(folder.file("vec4s.vdb"), std::ios::binary) << bytes;
  EXPECT_TRUE(says(refusal(folder.file("vec4s.vdb")), "vdb.tree_without_offsets"));
}

TEST(Vdb, ActiveValuesThatAreNoDensityBecomeZeroAndAreCounted) {
  const TemporaryFolder folder;
  const auto grid = open_grid("density");
  auto& tree = grid->tree();
  tree.setValue({100, 0, 0}, NAN);
  tree.setValue({100, 0, 1}, -1);
  tree.setValue({100, 0, 2}, -0.0f);
  tree.setValue({100, 0, 3}, 1e-44f);
  tree.addTile(1, {200, 0, 0}, HUGE_VALF, true);
  tree.addTile(2, {256, 0, 0}, -2, true);
  write_open(folder.file("a.vdb"), {grid}, openvdb::io::COMPRESS_BLOSC);
  const LoadedGrid got = read_vdb(folder.file("a.vdb"));
  EXPECT_EQ(got.report.non_finite, 1u + 512u);
  EXPECT_EQ(got.report.negative, 1u + (1u << 21));
  EXPECT_TRUE(got.grid.tiles.empty());
  EXPECT_EQ(sample(got.grid, {100, 0, 0}), 0);
  EXPECT_EQ(sample(got.grid, {100, 0, 1}), 0);
  EXPECT_FALSE(std::signbit(sample(got.grid, {100, 0, 2})));
  EXPECT_EQ(sample(got.grid, {100, 0, 3}), 1e-44f);
  EXPECT_NE(refusal(folder.file("a.vdb"), {"", true}).find("strict"), std::string::npos);
}

TEST(Vdb, DoublesBeyondFloatsAreNotFinite) {
  const TemporaryFolder folder;
  openvdb::initialize();
  const auto grid = openvdb::DoubleGrid::create();
  grid->setName("density");
  grid->tree().setValue({0, 0, 0}, 1e300);
  grid->tree().setValue({0, 0, 1}, 0.1);
  grid->tree().addTile(1, {8, 0, 0}, 0.2, true);
  write_open(folder.file("a.vdb"), {grid}, openvdb::io::COMPRESS_ZIP);
  const LoadedGrid got = read_vdb(folder.file("a.vdb"));
  EXPECT_EQ(got.report.type, "double");
  EXPECT_EQ(got.report.non_finite, 1u);
  EXPECT_EQ(sample(got.grid, {0, 0, 1}), 0.1f);
  EXPECT_EQ(sample(got.grid, {9, 7, 7}), 0.2f);
}

// ---------------------------------------------------------------------------------------------
// Damage

TEST(Vdb, NoTruncatedFileLoads) {
  const TemporaryFolder folder;
  const VoxelGrid grid = noise_grid({{0, 0, 0}, {4096, 8, 8}}, 9);
  write_vdb(folder.file("a.vdb"), {&grid});
  const std::string bytes = read_bytes(folder.file("a.vdb"));
  for (std::size_t n = 0; n < bytes.size(); n += n < 1000 || n + 600 > bytes.size() ? 1 : 13) {
    write_bytes(folder.file("b.vdb"), bytes.substr(0, n));
    ASSERT_NE(refusal(folder.file("b.vdb")), "") << n << " of " << bytes.size() << " bytes";
  }
}

/// A flipped bit is found, or changes values or the map and nothing else: never a crash, never
/// another set of voxels.
void flip_bits(const fs::path& scratch, const std::string& bytes, const VoxelGrid& grid,
               int flips) {
  std::mt19937 random(11);
  int found = 0;
  for (int i = 0; i < flips; ++i) {
    // Half of the flips near the start, where the structure is.
    const std::size_t range = i % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 900);
    const std::size_t bit = std::uniform_int_distribution<std::size_t>(0, range * 8 - 1)(random);
    std::string damaged = bytes;
    damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << (bit % 8)));
    write_bytes(scratch, damaged);
    try {
      const LoadedGrid got = read_vdb(scratch);
      ASSERT_LE(samples_of(got.grid), samples_of(grid)) << "bit " << bit;
    } catch (const Error&) {
      ++found;
    }
  }
  EXPECT_GT(found, flips / 10);
}

TEST(Vdb, FlippedBitsNeverCrash) {
  const TemporaryFolder folder;
  const auto grid = open_grid("density");
  for (const std::uint32_t compression : kCompressions) {
    SCOPED_TRACE(compression);
    write_open(folder.file("a.vdb"), {grid}, compression);
    flip_bits(folder.file("b.vdb"), read_bytes(folder.file("a.vdb")),
              read_vdb(folder.file("a.vdb")).grid, 150);
  }
}

}  // namespace vdb_test
}  // namespace pvol::formats
