// Every shared .vdb file: what it loads as, or why it is refused.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "pvol/formats/vdb.h"
#include "support/vdb_files.h"

namespace pvol::formats {
namespace shared_vdb_test {

namespace fs = std::filesystem;
using test::all;
using test::refusal;
using test::SampleFinder;

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
    {"bad/levelset_class_unknown.vdb", "is a level set, though not marked as one"},
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
    const SampleFinder lookup(got.grid);
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

}  // namespace shared_vdb_test
}  // namespace pvol::formats
