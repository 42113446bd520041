// Every shared .vdb file: what it loads as, or why it is refused.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "pvol/formats/vdb.h"
#include "support/messages.h"
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
  const char* warning = "";  ///< key of a warning; empty: there are none
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
    {"odd/three_grids_named_density.vdb", 491, 0, 0, 10, "vdb.three_grids_of_a_name"},
    {"bad/all_active_zero.vdb", 8000000, 0, 0, 0, "vdb.empty"},
    {"bad/bad-bbox-empty.vdb", 0, 0, 0, 0, "vdb.empty"},
    {"bad/bad-bbox-inverted.vdb", 0, 0, 0, 0, "vdb.empty"},
    {"bad/bitflip_5.vdb", 415642, 0, 0, 1},  // one value is another: nothing in the file tells
    {"bad/denormal_values.vdb", 71983, 0, 0, 8.72154e-41},
    {"bad/double_density.vdb", 71983, 0, 0, 0.872154},
    {"bad/duplicate_names.vdb", 71983, 0, 0, 0.872154, "vdb.two_grids_of_a_name"},
    {"bad/duplicate_names.vdb", 71983, 0, 0, 0.5, "", "density[1]"},
    {"bad/empty_grid.vdb", 0, 0, 0, 0, "vdb.empty"},
    {"bad/float_uncompressed.vdb", 71983, 0, 0, 0.872154},
    {"bad/giant_voxel_1e9.vdb", 71983, 0, 0, 0.872154},
    {"bad/half_blosc.vdb", 71983, 0, 0, 0.8720703125},
    {"bad/huge_index_offset_2p30.vdb", 71983, 0, 0, 0.872154},
    {"bad/huge_value_3e38.vdb", 71983, 0, 0, 3e38},
    {"bad/inactive_nonbackground_value.vdb", 71983, 0, 0, 0.872154, "vdb.inactive_voxels_hold"},
    {"bad/inf_one_voxel.vdb", 71983, 1, 0, 0.872154, "vdb.voxel_not_finite"},
    {"bad/int32_limit_coords.vdb", 2, 0, 0, 1},
    {"bad/mirrored_x.vdb", 71983, 0, 0, 0.872154},
    {"bad/name_5000_chars.vdb", 71983, 0, 0, 0.872154},
    {"bad/nan_background_inactive.vdb", 1, 0, 0, 1, "vdb.empty_space_grid_holds_nan"},
    {"bad/nan_one_voxel.vdb", 71983, 1, 0, 0.872154, "vdb.active_voxels_not_finite"},
    {"bad/neg_inf_one_voxel.vdb", 71983, 1, 0, 0.872154, "vdb.active_voxels_not_finite"},
    {"bad/negative_density.vdb", 71983, 0, 10283, 0.872154, "vdb.active_voxels_negative"},
    {"bad/no_density_name.vdb", 71983, 0, 0, 0.872154},
    {"bad/nonuniform_scale.vdb", 71983, 0, 0, 0.872154},
    {"bad/nonzero_background.vdb", 4096, 0, 0, 1, "vdb.empty_space_grid"},
    {"bad/odd_utf8_name.vdb", 71983, 0, 0, 0.872154},
    {"bad/real_nan_and_negatives.vdb", 531441, 1, 265260, 1.38177, "vdb.active_voxels_not_finite"},
    {"bad/root_tile_4096.vdb", std::uint64_t(1) << 36, 0, 0, 0.25},
    {"bad/rotated_uniform.vdb", 71983, 0, 0, 0.872154},
    {"bad/sheared.vdb", 71983, 0, 0, 0.872154},
    {"bad/single_voxel.vdb", 1, 0, 0, 2},
    {"bad/stream_no_offsets.vdb", 71983, 0, 0, 0.872154},
    {"bad/temperature_bg_300.vdb", 71983, 0, 0, 0.872154},
    {"bad/temperature_bg_300.vdb", 1331, 0, 0, 2000, "vdb.empty_space_grid_holds", "temperature"},
    {"bad/temperature_other_transform.vdb", 71983, 0, 0, 0.872154},
    {"bad/tiny_voxel_2e-5.vdb", 71983, 0, 0, 0.872154},
    {"bad/trailing_zeros.vdb", 415642, 0, 0, 1, "vdb.bytes_follow_last"},
    {"bad/two_clusters_4e9_apart.vdb", 16, 0, 0, 1},
    {"bad/unnamed_grid.vdb", 71983, 0, 0, 0.872154},
    {"bad/world_offset_1e8.vdb", 71983, 0, 0, 0.872154},
    {"bad/zip_class_unknown.vdb", 71983, 0, 0, 0.872154},
};

struct Refused {
  const char* file;
  const char* because;  ///< key of the message
};

constexpr Refused kRefused[] = {
    {"embergen_fire_a_60.vdb", "vdb.no_grid_called_density"},
    {"embergen_fire_a_75.vdb", "vdb.no_grid_called_density_several"},
    {"bad/bad-bbox-bomb.d029d3.vdb", "vdb.header_byte_format"},
    {"bad/bad-bbox-bomb.vdb", "vdb.grid_active_voxels"},
    {"bad/bad-bbox-empty.389d6e.vdb", "vdb.header_byte_format"},
    {"bad/bad-bbox-huge.724b0b.vdb", "vdb.header_byte_format"},
    {"bad/bad-bbox-huge.vdb", "vdb.grid_active_voxels"},
    {"bad/bad-bbox-inverted.3691e5.vdb", "vdb.header_byte_format"},
    {"bad/bad-bbox-overflow.2c9baf.vdb", "vdb.header_byte_format"},
    {"bad/bad-bbox-overflow.vdb", "vdb.grid_active_voxels"},
    {"bad/bad-bbox-roundup.27bf4d.vdb", "vdb.header_byte_format"},
    {"bad/bad-bbox-roundup.vdb", "vdb.grid_active_voxels"},
    {"bad/bad_magic.vdb", "vdb.not_vdb_not_begin"},
    {"bad/bitflip_0.vdb", "vdb.grid_density_byte"},
    {"bad/bitflip_1.vdb", "vdb.grid_density_byte"},
    {"bad/bitflip_2.vdb", "vdb.grid_density_byte"},
    {"bad/bitflip_3.vdb", "vdb.grid_density_byte"},
    {"bad/bitflip_4.vdb", "vdb.grid_density_byte"},
    {"bad/bool_density.vdb", "vdb.grid_density_rendered"},
    {"bad/frustum.vdb", "vdb.grid_density_rendered_lies"},
    {"bad/future_version_99.vdb", "vdb.format_version_versions"},
    {"bad/int32_density.vdb", "vdb.grid_density_rendered_holds"},
    {"bad/levelset_class_unknown.vdb", "vdb.grid_density_level"},
    {"bad/levelset_named_density.vdb", "vdb.grid_density_rendered_level"},
    {"bad/mask_density.vdb", "vdb.grid_density_rendered_holds_off"},
    {"bad/no_grids.vdb", "vdb.holds_no_grids"},
    {"bad/real_level_set.vdb", "vdb.grid_ls_sphere_rendered"},
    {"bad/real_lfs_pointer.vdb", "vdb.git_lfs_pointer"},
    {"bad/real_point_grid.vdb", "vdb.grid_points_rendered"},
    {"bad/real_symlink_text_48bytes.vdb", "vdb.text_not_vdb"},
    {"bad/real_vec3_only.vdb", "vdb.grid_rendered_holds"},
    {"bad/teapot_cloud-RENDER-0.85.old.nvdb", "vdb.nanovdb_not_openvdb"},
    {"bad/trunc_200bytes.vdb", "vdb.grid_density_ends"},
    {"bad/trunc_8bytes.vdb", "vdb.cut_off_bytes"},
    {"bad/trunc_blosc_multigrid.vdb", "vdb.grid_temperature_ends"},
    {"bad/trunc_half.vdb", "vdb.grid_density_ends_byte"},
    {"bad/trunc_last_byte.vdb", "vdb.grid_density_ends_byte_bytes"},
    {"bad/trunc_zip_half.vdb", "vdb.zip_cut_off"},
    {"bad/truncated.14b066.vdb", "vdb.header_byte_format"},
    {"bad/truncated.vdb", "vdb.byte_grids_bytes"},
    {"bad/vec3s_density.vdb", "vdb.grid_rendered_holds"},
    {"bad/zero_bytes.vdb", "vdb.empty_bytes_not_vdb"},
};

class SharedVdb : public ::testing::Test {
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
    if (*want.warning != '\0') {
      EXPECT_TRUE(says(all(got.report.warnings), want.warning));
    }
    EXPECT_EQ(got.grid.bricks.empty() && got.grid.tiles.empty(), want.largest == 0);
    options.strict = true;
    EXPECT_EQ(refusal(folder / want.file, options).empty(), got.report.warnings.empty());
  }
}

TEST_F(SharedVdb, OtherFilesAreRefusedWithTheReason) {
  for (const Refused& want : kRefused) {
    const std::string message = refusal(folder / want.file);
    EXPECT_TRUE(says(message, want.because)) << want.file;
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
