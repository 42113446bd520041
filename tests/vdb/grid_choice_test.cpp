// Which grid of a file is taken, and what is said where none can be.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/vdb.h"
#include "support/messages.h"
#include "support/temporary_folder.h"
#include "support/vdb_files.h"

namespace pvol::formats {
namespace grid_choice_test {

using test::refusal;

VoxelGrid grid_called(const std::string& name, bool empty = false) {
  VoxelGrid g;
  g.name = name;
  if (!empty) g.tiles.push_back({{0, 0, 0}, 8, 0.5f});
  return g;
}

TEST(GridChoice, LongListsOfGridsEnd) {
  const TemporaryFolder folder;
  std::vector<VoxelGrid> grids;
  for (int i = 0; i < 14; ++i) grids.push_back(grid_called("part" + std::to_string(i)));
  std::vector<const VoxelGrid*> all;
  for (const VoxelGrid& g : grids) all.push_back(&g);
  write_vdb(folder.file("many.vdb"), all);
  EXPECT_TRUE(says(refusal(folder.file("many.vdb")), "grids.no_grid_called"));
}

TEST(GridChoice, WhereNoneHoldsADensityAllAreListed) {
  const TemporaryFolder folder;
  openvdb::initialize();
  openvdb::GridPtrVec grids;
  for (const char* name : {"a", "b"}) {
    grids.push_back(openvdb::Vec3SGrid::create());
    grids.back()->setName(name);
  }
  const std::string file = folder.file("none.vdb").string();
  openvdb::io::File(file).write(grids);
  EXPECT_TRUE(says(refusal(file), "grids.no_grid_holds"));
}

/// An empty cloud is most likely the wrong grid of the file.
TEST(GridChoice, AnEmptyGridPointsToTheOthers) {
  const TemporaryFolder folder;
  const VoxelGrid empty = grid_called("density", true), full = grid_called("smoke");
  write_vdb(folder.file("two.vdb"), {&empty, &full});
  const auto warnings = [&](const char* grid) {
    return test::all(read_vdb(folder.file("two.vdb"), {grid, false}).report.warnings);
  };
  EXPECT_TRUE(says(warnings(""), "grids.choose_another_grid"));
  EXPECT_EQ(warnings("density").find("--grid"), std::string::npos) << "it was asked for by name";
}

/// Files of one grid: another name is a mistake.
TEST(GridChoice, RecipesAndPvolFilesHoldOneGrid) {
  const TemporaryFolder folder;
  const std::filesystem::path pvol = folder.file("a.pvol"), samples = PVOL_SAMPLES;
  const VoxelGrid grid = grid_called("smoke");
  PvolFile file;
  file.metadata.grid_name = "smoke";
  file.pyramid = build_pyramid(grid);
  file.density = grid;
  write_pvol(pvol, file);
  const auto refused = [](const std::filesystem::path& cloud, const char* name) -> std::string {
    try {
      (void)load_grid(cloud, {name, false});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refused(pvol, "smoke"), "");
  EXPECT_TRUE(says(refused(pvol, "fire"), "grids.holds_grid_smoke"));
  EXPECT_TRUE(says(refused(samples / "column.toml", "fire"), "grids.holds_grid"));
  EXPECT_TRUE(says(refused(samples / "cumulus_scene.toml", ""), "grids.scene_cloud_vdb"));
}

}  // namespace grid_choice_test
}  // namespace pvol::formats
