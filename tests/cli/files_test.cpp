// Every damaged, hostile or merely odd cloud through the tools: the right status, a message that
// names the file, and nothing left behind.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/effort.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace files_test {

using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

/// Damaged or unusable: only a refusal is right.
const std::set<std::string> kRefused = {"bad_magic.vdb",       "bool_density.vdb",
                                        "frustum.vdb",         "future_version_99.vdb",
                                        "int32_density.vdb",   "levelset_named_density.vdb",
                                        "mask_density.vdb",    "no_grids.vdb",
                                        "real_level_set.vdb",  "real_lfs_pointer.vdb",
                                        "real_point_grid.vdb", "real_symlink_text_48bytes.vdb",
                                        "real_vec3_only.vdb",  "trunc_200bytes.vdb",
                                        "trunc_8bytes.vdb",    "trunc_blosc_multigrid.vdb",
                                        "trunc_half.vdb",      "trunc_last_byte.vdb",
                                        "trunc_zip_half.vdb",  "truncated.14b066.vdb",
                                        "truncated.vdb",       "vec3s_density.vdb",
                                        "zero_bytes.vdb"};

/// Merely odd: these are clouds and must load.
const std::set<std::string> kAccepted = {"denormal_values.vdb",
                                         "double_density.vdb",
                                         "double_grid_smoke.vdb",
                                         "float_uncompressed.vdb",
                                         "giant_voxel_1e9.vdb",
                                         "half_blosc.vdb",
                                         "inactive_nonbackground_value.vdb",
                                         "inf_one_voxel.vdb",
                                         "mirrored_x.vdb",
                                         "name_5000_chars.vdb",
                                         "nan_background_inactive.vdb",
                                         "nan_one_voxel.vdb",
                                         "neg_inf_one_voxel.vdb",
                                         "negative_density.vdb",
                                         "no_density_name.vdb",
                                         "nonuniform_scale.vdb",
                                         "odd_utf8_name.vdb",
                                         "rotated_nonuniform.vdb",
                                         "rotated_uniform.vdb",
                                         "sheared.vdb",
                                         "single_voxel.vdb",
                                         "smoke1_blosc.nvdb",
                                         "stream_no_offsets.vdb",
                                         "temperature_bg_300.vdb",
                                         "temperature_other_transform.vdb",
                                         "tiny_voxel_2e-5.vdb",
                                         "unnamed_grid.vdb",
                                         "world_offset_1e8.vdb",
                                         "zip_class_unknown.vdb"};

/// Files of the folders bad and odd of the test clouds, in order: all, or on a commit those of them
/// whose turn it is for one of three tools, so that each goes through one.
std::vector<std::filesystem::path> hostile_files(std::size_t turn) {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"bad", "odd"}) {
    const auto path = std::filesystem::path(PVOL_SHARED_DATA) / folder;
    if (!std::filesystem::is_directory(path)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(path)) files.push_back(entry);
  }
  std::sort(files.begin(), files.end());
  if (proof::runs_all()) return files;
  std::vector<std::filesystem::path> some;
  for (std::size_t i = turn; i < files.size(); i += 3) some.push_back(files[i]);
  return some;
}

/// Runs a tool on a file and checks its status against what the file is; true where it succeeded.
bool check_status(const char* tool, const std::vector<std::string>& arguments,
                  const std::filesystem::path& file) {
  const std::string name = file.filename().string(), kind = file.extension().string();
  const RunResult r = run_tool(tool, arguments);
  EXPECT_EQ(r.signal, 0) << r.err;
  if (r.exit != 0) {
    EXPECT_NE(r.err.find(name), std::string::npos)
        << "the message does not name the file: " << r.err;
    EXPECT_EQ(r.out, "");
  }
  if (kind != ".vdb" && kind != ".nvdb") {
    EXPECT_NE(r.exit, 0);
  } else if (kRefused.contains(name)) {
    EXPECT_EQ(r.exit, 1) << r.out << r.err;
  } else if (kAccepted.contains(name)) {
    EXPECT_EQ(r.exit, 0) << r.err;
  } else {
    EXPECT_TRUE(r.exit == 0 || r.exit == 1) << r.exit << r.err;
  }
  return r.exit == 0;
}

TEST(HostileFiles, FitSucceedsWholeOrLeavesNothing) {
  const auto files = hostile_files(0);
  if (files.empty()) GTEST_SKIP() << "no test clouds at " << PVOL_SHARED_DATA;
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    const ScratchFolder folder;
    const std::string pvol = folder / "x.pvol";
    if (check_status(PVOL_FIT, {file.string(), "-o", pvol}, file)) {
      EXPECT_EQ(run_tool(PVOL_STATS, {"bounds", pvol}).exit, 0);
    } else {
      EXPECT_TRUE(folder.empty());
    }
  }
}

TEST(HostileFiles, RenderSucceedsOrLeavesNothing) {
  const auto files = hostile_files(1);
  if (files.empty()) GTEST_SKIP() << "no test clouds at " << PVOL_SHARED_DATA;
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    const ScratchFolder folder;
    const bool rendered = check_status(
        PVOL_RENDER, {file.string(), "-o", folder / "x.exr", "--size", "6x4", "--spp", "1"}, file);
    EXPECT_EQ(folder.empty(), !rendered);
  }
}

TEST(HostileFiles, ConvertSucceedsWholeOrLeavesNothing) {
  const auto files = hostile_files(2);
  if (files.empty()) GTEST_SKIP() << "no test clouds at " << PVOL_SHARED_DATA;
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    const ScratchFolder folder;
    const bool converted = check_status(PVOL_CONVERT, {file.string(), folder / "x.vdb"}, file);
    EXPECT_EQ(folder.empty(), !converted);
  }
}

TEST(HostileFiles, VoxelsTooFarApartAreRefused) {
  const auto file = std::filesystem::path(PVOL_SHARED_DATA) / "bad" / "two_clusters_4e9_apart.vdb";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no test clouds at " << PVOL_SHARED_DATA;
  const ScratchFolder folder;
  const RunResult r = run_tool(PVOL_FIT, {file, "-o", folder / "x.pvol"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_NE(r.err.find("two_clusters_4e9_apart.vdb"), std::string::npos) << r.err;
  EXPECT_TRUE(says(r.err, "tools.density_extends_over"));
}

TEST(HostileFiles, StrictRefusesNonFiniteAndNegativeValues) {
  const auto folder = std::filesystem::path(PVOL_SHARED_DATA) / "bad";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no test clouds at " << folder;
  for (const char* name : {"nan_one_voxel.vdb", "inf_one_voxel.vdb", "negative_density.vdb"}) {
    const ScratchFolder scratch;
    const std::string pvol = scratch / "x.pvol";
    EXPECT_EQ(run_tool(PVOL_FIT, {folder / name, "-o", pvol, "--strict"}).exit, 1) << name;
    EXPECT_TRUE(scratch.empty());
    const RunResult lenient = run_tool(PVOL_FIT, {folder / name, "-o", pvol});
    EXPECT_EQ(lenient.exit, 0) << name;
    EXPECT_NE(lenient.err.find("warning"), std::string::npos) << name;
  }
}

}  // namespace files_test
}  // namespace pvol
