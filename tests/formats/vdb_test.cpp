#include "pvol/formats/vdb.h"

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <bit>
#include <cstring>
#include <map>
#include <random>
#include <tuple>

#include "pvol/error.h"
#include "support/temporary_folder.h"

// OpenVDB loses a node where compressed values of it turn out to be damaged.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:readTopology"; }

namespace pvol::formats {
namespace {

namespace fs = std::filesystem;

/// Finds bricks fast, for comparing whole clouds.
struct Lookup {
  explicit Lookup(const VoxelGrid& g) : grid(g) {
    for (const Brick& b : g.bricks) bricks[{b.origin.x, b.origin.y, b.origin.z}] = b.values;
  }
  [[nodiscard]] float operator()(Vec3i p) const {
    const auto at = bricks.find({p.x & ~7, p.y & ~7, p.z & ~7});
    if (at != bricks.end()) return at->second[((p.x & 7) * 8 + (p.y & 7)) * 8 + (p.z & 7)];
    VoxelGrid tiles;
    tiles.tiles = grid.tiles;
    return sample(tiles, p);
  }
  const VoxelGrid& grid;
  std::map<std::tuple<int, int, int>, const float*> bricks;
};

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

/// What reading does: the message of the error, or nothing.
std::string refusal(const fs::path& file, const GridOptions& options = {}) {
  try {
    static_cast<void>(read_vdb(file, options));
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

std::string all(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& w : warnings) text += w + "\n";
  return text;
}

// ---------------------------------------------------------------------------------------------
// Files that exist

/// What becomes of a file. Counts are those that OpenVDB 10.0.1 gives.
struct Loads {
  const char* file;
  std::uint64_t active, non_finite, negative;
  double largest;
  const char* warning = "";  ///< part of the warnings; empty: there are none
  const char* grid = "";     ///< to ask for
};

constexpr Loads kLoads[] = {
    {"cumulus_448.vdb", 9571553, 0, 0, 1},
    {"embergen_fire_a_60.vdb", 378355, 0, 0, 1.2734375, "", "temperature"},
    {"embergen_fire_a_74_with_density.vdb", 216312, 0, 0, 1.2109375},
    {"embergen_fire_a_75.vdb", 413691, 0, 0, 1.265625, "", "temperature"},
    {"lajolla_smoke.vdb", 312306, 0, 0, 1},
    {"openusd_densityAndHeat.vdb", 6124, 0, 0, 0.997509},
    {"openusd_smoke_000003.vdb", 90197, 0, 0, 0.999985},
    {"smoke1.vdb", 1049275, 0, 0, 5.71484375},
    {"synthetic_cumulus.vdb", 1119114, 0, 0, 1.00867},
    {"synthetic_stratus.vdb", 173684, 0, 0, 0.827437},
    {"wdas_cloud_sixteenth.vdb", 415642, 0, 0, 1},
    {"wdas_x4_detail.vdb", 22169415, 0, 0, 1},
    {"odd/double_grid_smoke.vdb", 524288, 0, 0, 1},
    {"odd/rotated_nonuniform.vdb", 271492, 0, 0, 1},
    {"odd/three_grids_named_density.vdb", 491, 0, 0, 10, "3 grids are called 'density'"},
    {"bad/all_active_zero.vdb", 8000000, 0, 0, 0, "is empty"},
    {"bad/bad-bbox-empty.vdb", 0, 0, 0, 0, "is empty"},
    {"bad/bad-bbox-inverted.vdb", 0, 0, 0, 0, "is empty"},
    {"bad/bitflip_5.vdb", 415642, 0, 0, 1},  // one value is another: nothing in the file tells
    {"bad/denormal_values.vdb", 71983, 0, 0, 8.72154e-41},
    {"bad/double_density.vdb", 71983, 0, 0, 0.872154},
    {"bad/duplicate_names.vdb", 71983, 0, 0, 0.872154, "2 grids are called 'density'"},
    {"bad/duplicate_names.vdb", 71983, 0, 0, 0.5, "", "density[1]"},
    {"bad/empty_grid.vdb", 0, 0, 0, 0, "is empty"},
    {"bad/float_uncompressed.vdb", 71983, 0, 0, 0.872154},
    {"bad/giant_voxel_1e9.vdb", 71983, 0, 0, 0.872154},
    {"bad/half_blosc.vdb", 71983, 0, 0, 0.8720703125},
    {"bad/huge_index_offset_2p30.vdb", 71983, 0, 0, 0.872154},
    {"bad/huge_value_3e38.vdb", 71983, 0, 0, 3e38},
    {"bad/inactive_nonbackground_value.vdb", 71983, 0, 0, 0.872154, "1 inactive voxels"},
    {"bad/inf_one_voxel.vdb", 71983, 1, 0, 0.872154, "1 of 71983 active voxels are not finite"},
    {"bad/int32_limit_coords.vdb", 2, 0, 0, 1},
    {"bad/mirrored_x.vdb", 71983, 0, 0, 0.872154},
    {"bad/name_5000_chars.vdb", 71983, 0, 0, 0.872154},
    {"bad/nan_background_inactive.vdb", 1, 0, 0, 1, "its background"},
    {"bad/nan_one_voxel.vdb", 71983, 1, 0, 0.872154, "not finite"},
    {"bad/neg_inf_one_voxel.vdb", 71983, 1, 0, 0.872154, "not finite"},
    {"bad/negative_density.vdb", 71983, 0, 10283, 0.872154, "10283 of 71983"},
    {"bad/no_density_name.vdb", 71983, 0, 0, 0.872154},
    {"bad/nonuniform_scale.vdb", 71983, 0, 0, 0.872154},
    {"bad/nonzero_background.vdb", 4096, 0, 0, 1, "holds 0.5 (its background)"},
    {"bad/odd_utf8_name.vdb", 71983, 0, 0, 0.872154},
    {"bad/real_nan_and_negatives.vdb", 531441, 1, 265260, 1.38177, "not finite"},
    {"bad/root_tile_4096.vdb", std::uint64_t(1) << 36, 0, 0, 0.25},
    {"bad/rotated_uniform.vdb", 71983, 0, 0, 0.872154},
    {"bad/sheared.vdb", 71983, 0, 0, 0.872154},
    {"bad/single_voxel.vdb", 1, 0, 0, 2},
    {"bad/stream_no_offsets.vdb", 71983, 0, 0, 0.872154},
    {"bad/temperature_bg_300.vdb", 71983, 0, 0, 0.872154},
    {"bad/temperature_bg_300.vdb", 1331, 0, 0, 2000, "holds 300 (its background)", "temperature"},
    {"bad/temperature_other_transform.vdb", 71983, 0, 0, 0.872154},
    {"bad/tiny_voxel_2e-5.vdb", 71983, 0, 0, 0.872154},
    {"bad/trailing_zeros.vdb", 415642, 0, 0, 1, "1000 bytes follow"},
    {"bad/two_clusters_4e9_apart.vdb", 16, 0, 0, 1},
    {"bad/unnamed_grid.vdb", 71983, 0, 0, 0.872154},
    {"bad/world_offset_1e8.vdb", 71983, 0, 0, 0.872154},
    {"bad/zip_class_unknown.vdb", 71983, 0, 0, 0.872154},
};

struct Refused {
  const char* file;
  const char* because;
};

constexpr Refused kRefused[] = {
    {"embergen_fire_a_60.vdb", "temperature (half), flames (half)"},
    {"embergen_fire_a_75.vdb", "choose one with --grid NAME"},
    {"bad/bad-bbox-bomb.d029d3.vdb", "version 225"},
    {"bad/bad-bbox-bomb.vdb", "do not fill the box"},
    {"bad/bad-bbox-empty.389d6e.vdb", "version 225"},
    {"bad/bad-bbox-huge.724b0b.vdb", "version 225"},
    {"bad/bad-bbox-huge.vdb", "do not fill the box"},
    {"bad/bad-bbox-inverted.3691e5.vdb", "version 225"},
    {"bad/bad-bbox-overflow.2c9baf.vdb", "version 225"},
    {"bad/bad-bbox-overflow.vdb", "do not fill the box"},
    {"bad/bad-bbox-roundup.27bf4d.vdb", "version 225"},
    {"bad/bad-bbox-roundup.vdb", "do not fill the box"},
    {"bad/bad_magic.vdb", "is not a .vdb file"},
    {"bad/bitflip_0.vdb", "damaged"},
    {"bad/bitflip_1.vdb", "damaged"},
    {"bad/bitflip_2.vdb", "damaged"},
    {"bad/bitflip_3.vdb", "damaged"},
    {"bad/bitflip_4.vdb", "damaged"},
    {"bad/bool_density.vdb", "on/off values (bool)"},
    {"bad/frustum.vdb", "frustum"},
    {"bad/future_version_99.vdb", "version 99"},
    {"bad/int32_density.vdb", "whole numbers (int32)"},
    {"bad/levelset_class_unknown.vdb", "is a level set though"},
    {"bad/levelset_named_density.vdb", "density (float, level set)"},
    {"bad/mask_density.vdb", "on/off values (mask)"},
    {"bad/no_grids.vdb", "holds no grids"},
    {"bad/real_level_set.vdb", "level set"},
    {"bad/real_lfs_pointer.vdb", "git lfs pull"},
    {"bad/real_point_grid.vdb", "points"},
    {"bad/real_symlink_text_48bytes.vdb", "is a text file"},
    {"bad/real_vec3_only.vdb", "vectors (vec3s)"},
    {"bad/teapot_cloud-RENDER-0.85.old.nvdb", "NanoVDB file"},
    {"bad/trunc_200bytes.vdb", "cut off"},
    {"bad/trunc_8bytes.vdb", "cut off"},
    {"bad/trunc_blosc_multigrid.vdb", "cut off"},
    {"bad/trunc_half.vdb", "has 815810 bytes"},
    {"bad/trunc_last_byte.vdb", "ends at byte 1631620, but the file has 1631619"},
    {"bad/trunc_zip_half.vdb", "cut off"},
    {"bad/truncated.14b066.vdb", "version 225"},
    {"bad/truncated.vdb", "cut off"},
    {"bad/vec3s_density.vdb", "vectors (vec3s)"},
    {"bad/zero_bytes.vdb", "is empty (0 bytes)"},
};

class SharedVdb : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(folder)) GTEST_SKIP() << "no test clouds in " << folder;
  }
  fs::path folder = PVOL_SHARED_DATA;
};

TEST_F(SharedVdb, UsableFilesLoadWithTheirCountsAndWarnings) {
  for (const Loads& want : kLoads) {
    SCOPED_TRACE(want.file);
    GridOptions options;
    options.grid = want.grid;
    LoadedGrid got;
    ASSERT_NO_THROW(got = read_vdb(folder / want.file, options));
    EXPECT_EQ(got.report.active, want.active);
    EXPECT_EQ(got.report.non_finite, want.non_finite);
    EXPECT_EQ(got.report.negative, want.negative);
    EXPECT_NEAR(double(got.report.largest), want.largest, want.largest * 1e-5);
    EXPECT_EQ(got.report.warnings.empty(), *want.warning == '\0') << all(got.report.warnings);
    EXPECT_NE(all(got.report.warnings).find(want.warning), std::string::npos)
        << all(got.report.warnings);
    EXPECT_EQ(got.grid.bricks.empty() && got.grid.tiles.empty(), want.largest == 0);
    options.strict = true;
    EXPECT_EQ(refusal(folder / want.file, options).empty(), got.report.warnings.empty());
  }
}

TEST_F(SharedVdb, OtherFilesAreRefusedWithTheReason) {
  for (const Refused& want : kRefused) {
    const std::string message = refusal(folder / want.file);
    EXPECT_NE(message.find(want.because), std::string::npos) << want.file << ": " << message;
    EXPECT_NE(message.find(want.file), std::string::npos) << message;
  }
}

TEST_F(SharedVdb, EveryFileIsInOneOfTheTables) {
  for (const char* sub : {"", "bad", "odd"}) {
    for (const auto& entry : fs::directory_iterator(folder / sub)) {
      if (entry.path().extension() != ".vdb") continue;
      const std::string name = fs::relative(entry.path(), folder).string();
      const auto is_it = [&](const auto& row) { return name == row.file; };
      EXPECT_TRUE(std::any_of(std::begin(kLoads), std::end(kLoads), is_it) ||
                  std::any_of(std::begin(kRefused), std::end(kRefused), is_it))
          << name;
    }
  }
}

openvdb::GridBase::Ptr read_with_openvdb(const fs::path& file, const std::string& name) {
  openvdb::initialize();
  openvdb::io::File in(file.string());
  in.open(false);
  return in.readGrid(name);
}

TEST_F(SharedVdb, SamplesAreThoseOfOpenVdb) {
  const std::pair<const char*, const char*> files[] = {
      {"wdas_cloud_sixteenth.vdb", "density"},   {"smoke1.vdb", "density"},
      {"embergen_fire_a_75.vdb", "temperature"}, {"odd/rotated_nonuniform.vdb", "density"},
      {"bad/zip_class_unknown.vdb", "density"},  {"bad/huge_index_offset_2p30.vdb", "density"},
      {"bad/stream_no_offsets.vdb", "density"},  {"bad/denormal_values.vdb", "density"}};
  for (const auto& [file, name] : files) {
    SCOPED_TRACE(file);
    GridOptions options;
    options.grid = name;
    const LoadedGrid got = read_vdb(folder / file, options);
    const auto want =
        openvdb::gridPtrCast<openvdb::FloatGrid>(read_with_openvdb(folder / file, name));
    const Lookup lookup(got.grid);
    double sum = 0;
    std::size_t wrong = 0;
    for (auto it = want->cbeginValueOn(); it; ++it) {
      if (it.isTileValue()) continue;
      const openvdb::Coord c = it.getCoord();
      wrong += std::bit_cast<std::uint32_t>(lookup({c.x(), c.y(), c.z()})) !=
               std::bit_cast<std::uint32_t>(*it);
      sum += double(*it);
    }
    EXPECT_EQ(wrong, 0u);
    double bricks = 0;  // nothing but the active values
    for (const Brick& b : got.grid.bricks) {
      for (int i = 0; i < kBrickSamples; ++i) bricks += double(b.values[i]);
    }
    EXPECT_NEAR(bricks, sum, 1e-9 * sum);
    std::mt19937 random(7);
    const openvdb::CoordBBox box = want->evalActiveVoxelBoundingBox();
    const auto accessor = want->getConstAccessor();
    for (int i = 0; i < 20000; ++i) {
      openvdb::Coord c;
      for (int a = 0; a < 3; ++a) {
        c[a] = std::uniform_int_distribution<int>(box.min()[a] - 9, box.max()[a] + 9)(random);
      }
      ASSERT_EQ(lookup({c.x(), c.y(), c.z()}), accessor.getValue(c));
    }
  }
}

TEST_F(SharedVdb, MapsToTheWorldAreThoseOfOpenVdb) {
  for (const char* file :
       {"odd/rotated_nonuniform.vdb", "bad/rotated_uniform.vdb", "bad/sheared.vdb",
        "bad/mirrored_x.vdb", "bad/nonuniform_scale.vdb", "smoke1.vdb", "bad/world_offset_1e8.vdb",
        "bad/tiny_voxel_2e-5.vdb", "bad/giant_voxel_1e9.vdb", "openusd_smoke_000003.vdb"}) {
    SCOPED_TRACE(file);
    const Affine got = read_vdb(folder / file).grid.index_to_world;
    const auto want = read_with_openvdb(folder / file, "density");
    for (const Vec3d p : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1},
                          Vec3d{17.25, -3.5, 1000}}) {
      const openvdb::Vec3d w = want->indexToWorld(openvdb::Vec3d(p.x, p.y, p.z));
      const Vec3d mine = got.point(p);
      const double size = 1e-14 * (std::abs(w.x()) + std::abs(w.y()) + std::abs(w.z()));
      EXPECT_NEAR(mine.x, w.x(), size);
      EXPECT_NEAR(mine.y, w.y(), size);
      EXPECT_NEAR(mine.z, w.z(), size);
    }
  }
}

// ---------------------------------------------------------------------------------------------
// Files made here

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
  EXPECT_NE(all(empty.report.warnings).find("is empty"), std::string::npos);
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
    EXPECT_NE(refusal(folder.file("b.vdb")).find("map to the world"), std::string::npos) << bad;
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
  EXPECT_NE(refusal(two, {"minorant", false}).find("majorant (float), density (float)"),
            std::string::npos);
  a.name = "minorant";
  write_vdb(folder.file("none.vdb"), {&b, &a});
  EXPECT_NE(refusal(folder.file("none.vdb")).find("choose one with --grid NAME"),
            std::string::npos);

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
  EXPECT_NE(refusal(folder.file("absent.vdb")).find("cannot open"), std::string::npos);
  EXPECT_NE(refusal(folder.file("")).find("not a regular file"), std::string::npos);
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
      EXPECT_NE(all(got.report.warnings).find("515 inactive voxels"), std::string::npos)
          << all(got.report.warnings);
      const Lookup lookup(got.grid);
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
  std::ofstream points(folder.file("bool.vdb"), std::ios::binary);
  openvdb::io::Stream(points).write(openvdb::GridPtrVec{openvdb::BoolGrid::create(), density});
  points.close();
  EXPECT_NE(refusal(folder.file("bool.vdb")).find("save it with offsets"), std::string::npos);
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

}  // namespace
}  // namespace pvol::formats
