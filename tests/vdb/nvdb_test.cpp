#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include <cstring>
#include <random>

#include "pvol/error.h"
#include "pvol/formats/vdb.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace nvdb_test {

namespace fs = std::filesystem;
using nanovdb::io::Codec;

std::string refusal(const fs::path& file, const GridOptions& options = {}) {
  try {
    static_cast<void>(read_nvdb(file, options));
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

openvdb::FloatGrid::Ptr open_grid(const std::string& name) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  openvdb::Mat4d m = openvdb::Mat4d::identity();
  m.postRotate(openvdb::math::Y_AXIS, 0.5);
  m.postScale(openvdb::Vec3d(0.5, 2, 1));
  m.postTranslate(openvdb::Vec3d(3, -4, 5));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
  std::mt19937 random(5);
  for (int i = 0; i < 4000; ++i) {
    grid->tree().setValue({int(random() % 60) - 30, int(random() % 20) - 5000, int(random() % 9)},
                          float(random() % 4096 + 1) / 1024);
  }
  grid->tree().addTile(1, {160, 0, 0}, 0.5f, true);
  grid->tree().addTile(2, {256, 0, 0}, 1.5f, true);
  grid->tree().addTile(3, {-8192, 4096, 0}, 2.5f, true);
  return grid;
}

void expect_same(const LoadedGrid& got, const openvdb::FloatGrid& want, float tolerance) {
  EXPECT_EQ(got.report.active, want.activeVoxelCount());
  for (auto it = want.cbeginValueOn(); it; ++it) {
    const openvdb::Coord c = it.getCoord();
    ASSERT_NEAR(sample(got.grid, {c.x(), c.y(), c.z()}), *it, tolerance) << c;
  }
  std::size_t above = 0, active = 0;
  for (const Brick& b : got.grid.bricks) {
    above += std::size_t(std::count_if(b.values, b.values + 512, [](float v) { return v > 0; }));
  }
  for (auto leaf = want.tree().cbeginLeaf(); leaf; ++leaf) active += leaf->onVoxelCount();
  if (tolerance == 0) {
    EXPECT_EQ(above, active);  // nothing but the active values
  }
  for (const Vec3d p : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
    const openvdb::Vec3d w = want.indexToWorld(openvdb::Vec3d(p.x, p.y, p.z));
    const Vec3d mine = got.grid.index_to_world.point(p);
    EXPECT_NEAR(length(mine - Vec3d(w.x(), w.y(), w.z())), 0, 1e-14);
  }
}

TEST(Nvdb, EveryCodecGivesTheGridOfOpenVdb) {
  const TemporaryFolder folder;
  auto grid = open_grid("density");
  const auto handle = nanovdb::openToNanoVDB(*grid);
  for (const Codec codec : {Codec::NONE, Codec::ZIP, Codec::BLOSC}) {
    SCOPED_TRACE(nanovdb::io::toStr(codec));
    nanovdb::io::writeGrid(folder.file("a.nvdb").string(), handle, codec);
    const LoadedGrid got = read_nvdb(folder.file("a.nvdb"));
    expect_same(got, *grid, 0);
    EXPECT_EQ(got.report.grid, "density");
    EXPECT_EQ(got.report.type, "float");
    EXPECT_TRUE(got.report.warnings.empty()) << got.report.warnings.front();
    EXPECT_EQ(got.grid.tiles.size(), 3u);
  }
}

template <class T>
void expect_quantised(const std::string& type, float tolerance) {
  SCOPED_TRACE(type);
  const TemporaryFolder folder;
  auto grid = open_grid("density");
  const auto handle = nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, T>(*grid);
  nanovdb::io::writeGrid(folder.file("a.nvdb").string(), handle, Codec::ZIP);
  const LoadedGrid got = read_nvdb(folder.file("a.nvdb"));
  expect_same(got, *grid, tolerance);
  EXPECT_EQ(got.report.type, type);
}

TEST(Nvdb, QuantisedGridsLoadWithinTheirPrecision) {
  expect_quantised<nanovdb::Fp4>("fp4", 4.0f / 15);
  expect_quantised<nanovdb::Fp8>("fp8", 4.0f / 255);
  expect_quantised<nanovdb::Fp16>("fp16", 4.0f / 65535);
  expect_quantised<nanovdb::FpN>("fpN", 0.1f);
}

TEST(Nvdb, GridsAreChosenAsInVdbFiles) {
  const TemporaryFolder folder;
  std::vector<nanovdb::GridHandle<>> handles;
  for (const char* name : {"flames", "density", "density"}) {
    auto grid = open_grid(name);
    if (handles.size() == 2) grid->tree().addTile(3, {8192, 0, 0}, 9, true);
    handles.push_back(nanovdb::openToNanoVDB(*grid));
  }
  auto surface = open_grid("surface");
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  handles.push_back(nanovdb::openToNanoVDB(*surface));
  auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("v");
  handles.push_back(nanovdb::openToNanoVDB(*velocity));
  nanovdb::io::writeGrids(folder.file("a.nvdb").string(), handles, Codec::BLOSC);
  const fs::path file = folder.file("a.nvdb");
  EXPECT_EQ(read_nvdb(file).report.grid, "density[0]");
  EXPECT_EQ(read_nvdb(file).report.warnings.size(), 1u);
  EXPECT_EQ(read_nvdb(file, {"density[1]", true}).report.largest, 9);
  EXPECT_EQ(read_nvdb(file, {"flames", true}).grid.name, "flames");
  EXPECT_TRUE(says(refusal(file, {"surface", false}), "vdb.grid_surface_rendered"));
  EXPECT_NE(refusal(file, {"v", false}).find("vec3s"), std::string::npos);
  EXPECT_TRUE(says(refusal(file, {"x", false}), "vdb.no_grid_called"));
}

TEST(Nvdb, SharedFileHasTheValuesOfItsOriginal) {
  const fs::path folder = PVOL_SHARED_DATA;
  if (!fs::exists(folder)) GTEST_SKIP() << "no test clouds in " << folder;
  const LoadedGrid nano = read_nvdb(folder / "odd/smoke1_blosc.nvdb");
  const LoadedGrid open = read_vdb(folder / "smoke1.vdb");
  EXPECT_EQ(nano.report.active, 1049275u);
  EXPECT_TRUE(nano.report.warnings.empty());
  ASSERT_EQ(nano.grid.bricks.size(), open.grid.bricks.size());
  for (std::size_t i = 0; i < open.grid.bricks.size(); ++i) {
    ASSERT_EQ(nano.grid.bricks[i].origin, open.grid.bricks[i].origin);
    ASSERT_EQ(std::memcmp(nano.grid.bricks[i].values, open.grid.bricks[i].values,
                          kBrickSamples * sizeof(float)),
              0);
  }
  const fs::path old = folder / "bad/teapot_cloud-RENDER-0.85.old.nvdb";
  EXPECT_TRUE(says(refusal(old), "vdb.byte_nanovdb_version"));
  EXPECT_TRUE(says(refusal(folder / "smoke1.vdb"), "vdb.openvdb_not_nanovdb"));
  EXPECT_TRUE(says(refusal(folder / "bad/zero_bytes.vdb"), "vdb.nvdb_of_no_bytes"));
}

TEST(Nvdb, UndeclaredLevelSetsAreKnownByTheirInsideInLeaves) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(1.5f);
  grid->setName("density");
  for (int i = 0; i < 8; ++i) grid->tree().setValue({i, 3, 4}, 0.25f);
  grid->tree().setValueOff({3, 5, 4}, -1.5f);
  nanovdb::io::writeGrid(folder.file("a.nvdb").string(), nanovdb::openToNanoVDB(*grid));
  EXPECT_TRUE(says(refusal(folder.file("a.nvdb")), "vdb.unmarked_level_set"));
}

TEST(Nvdb, NewerFilesAreRefusedByName) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.nvdb"), "NanoVDB2" + std::string(500, 'x'));
  EXPECT_TRUE(says(refusal(folder.file("a.nvdb")), "vdb.newer_nanovdb"));
}

/// Without a checksum, which would refuse damage before the nodes are walked.
nanovdb::GridHandle<> unchecked(const openvdb::FloatGrid& grid) {
  return nanovdb::openToNanoVDB(grid, nanovdb::StatsMode::Default, nanovdb::ChecksumMode::Disable);
}

TEST(Nvdb, NoTruncatedFileLoadsAndFlippedBitsNeverCrash) {
  const TemporaryFolder folder;
  const auto handle = unchecked(*open_grid("density"));
  const LoadedGrid whole = [&] {
    nanovdb::io::writeGrid(folder.file("a.nvdb").string(), handle, Codec::NONE);
    return read_nvdb(folder.file("a.nvdb"));
  }();
  std::mt19937 random(3);
  for (const Codec codec : {Codec::NONE, Codec::ZIP, Codec::BLOSC}) {
    SCOPED_TRACE(nanovdb::io::toStr(codec));
    nanovdb::io::writeGrid(folder.file("a.nvdb").string(), handle, codec);
    const std::string bytes = read_bytes(folder.file("a.nvdb"));
    for (std::size_t n = 0; n < bytes.size(); n += n < 1000 ? 17 : bytes.size() / 40) {
      write_bytes(folder.file("b.nvdb"), bytes.substr(0, n));
      ASSERT_FALSE(refusal(folder.file("b.nvdb")).empty()) << n;
    }
    for (int i = 0; i < 150; ++i) {
      const std::size_t range = i % 2 ? bytes.size() : 2000;
      const std::size_t bit = random() % (std::min(range, bytes.size()) * 8);
      std::string damaged = bytes;
      damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << (bit % 8)));
      write_bytes(folder.file("b.nvdb"), damaged);
      try {
        ASSERT_LE(read_nvdb(folder.file("b.nvdb")).grid.bricks.size(), whole.grid.bricks.size());
      } catch (const Error&) {
      }
    }
  }
}

TEST(Nvdb, OffsetsThatLeaveTheGridAreRefused) {
  const TemporaryFolder folder;
  const auto grid = open_grid("density");
  const auto handle = unchecked(*grid);
  nanovdb::io::writeGrid(folder.file("a.nvdb").string(), handle, Codec::NONE);
  const std::string bytes = read_bytes(folder.file("a.nvdb"));
  const auto* nano = handle.grid<float>();
  const auto* start = reinterpret_cast<const char*>(nano);
  const std::size_t data = bytes.size() - handle.size();
  const auto& root = nano->tree().root();
  const auto* tile = reinterpret_cast<const char*>(&root) + sizeof(root);
  const auto* upper = reinterpret_cast<const char*>(nano->tree().getFirstUpper());
  // Root's offset, size of the root's table, offset of a child, and the map of an upper node.
  const std::size_t places[] = {
      672 + 24, std::size_t(reinterpret_cast<const char*>(&root) - start) + 24,
      std::size_t(tile - start) + 8, std::size_t(upper - start) + 32 + 4096};
  std::mt19937_64 random(1);
  for (const std::size_t place : places) {
    for (int i = 0; i < 40; ++i) {
      std::string damaged = bytes;
      const std::uint64_t value = random() >> (random() % 64);
      std::memcpy(damaged.data() + data + place, &value, 8);
      write_bytes(folder.file("b.nvdb"), damaged);
      static_cast<void>(refusal(folder.file("b.nvdb")));  // and no crash
    }
  }
}

}  // namespace nvdb_test
}  // namespace pvol::formats
