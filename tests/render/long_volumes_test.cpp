// Volumes as long as places in floats allow (THEORY.md, T2.2): the far end is as right as the near
// one.
#include <gtest/gtest.h>

#include "pvol/bounds/pyramid.h"
#include "support/lit_scenes.h"
#include "support/wavefront_shots.h"
#include "volume/simd/simd_field.h"

namespace pvol::test {
namespace long_volumes_test {

/// The puff twice, with air between: `apart` voxels, of whole bricks, along each axis.
VoxelGrid puffs(Vec3i apart) {
  VoxelGrid grid = puff().grid;
  const std::vector<Brick> once = grid.bricks;
  for (Brick b : once) {
    b.origin = b.origin + apart;
    grid.bricks.push_back(b);
  }
  return grid;
}

Volume volume_of(const VoxelGrid& grid, const CloudScene& s) {
  return make_volume(grid, build_pyramid(grid), s);
}

/// As if the camera stood before the first puff, beside the second.
Camera beside(Camera camera, Vec3i apart) {
  camera.position = camera.position + Vec3d(apart);
  camera.target = camera.target + Vec3d(apart);
  return camera;
}

constexpr int kFar = 16 * 1000;

/// Views of the far puff, along the box and across it.
std::vector<Shot> shots() {
  std::vector<Shot> all;
  for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
    CloudScene s = sunny();
    s.options.guide = guide;
    const Camera near =
        frame(make_volume(puff().grid, build_pyramid(puff().grid), s).density.world_box, 1);
    for (const Vec3i apart : {Vec3i(kFar, 0, 0), Vec3i(0, 80, kFar)}) {
      const VoxelGrid grid = puffs(apart);
      s.camera = beside(near, apart);
      all.push_back({name_of(apart.x > 0 ? "along x" : "along z", guide), s, {volume_of(grid, s)}});
    }
  }
  return all;
}

TEST(LongVolumes, HaveTheMeansOfFlightsOneByOne) {
  for (const Shot& shot : shots()) {
    EXPECT_EQ(detail::simd_obstacle(shot.volumes[0]), nullptr) << shot.name;
  }
  expect_means_of_flights_one_by_one(shots(), 300);
}
TEST(LongVolumes, OfEveryWidthGiveTheSameBytes) { expect_same_at_every_width(shots()); }

/// The two puffs are alike, so pictures of either from beside it are, but for light that comes from
/// the other: a hundred-thousandth of all directions.
TEST(LongVolumes, ShowTheSameAtBothEnds) {
  const Vec3i apart(kFar, 0, 0);
  const VoxelGrid grid = puffs(apart);
  CloudScene s = sunny();
  s.options.samples = proof::samples(2000);
  Shot shot{"", s, {volume_of(grid, s)}};
  const Camera near =
      frame(make_volume(puff().grid, build_pyramid(puff().grid), s).density.world_box, 1);
  proof::Family family;
  proof::Moments deviations;
  for (const KernelKind kernel : kernels_to_try()) {
    shot.scene.camera = near;
    const Film first = render_with(kernel, shot, shot.scene);
    CloudScene other = shot.scene;
    other.camera = beside(near, apart), other.options.seed = 7;
    const Film second = render_with(kernel, shot, other);
    compare(first, second, name(kernel), family);
    deviations.add(compare(average(first), average(second), name(kernel), family));
  }
  add_all_together(deviations, family);
  EXPECT_TRUE(family.passes());
}

/// Where they are longer, or their boxes hold far more air than density, flights go one by one.
TEST(LongVolumes, GoOneByOneBeyondTheLimits) {
  const CloudScene s = sunny();
  const auto obstacle = [&](Vec3i apart) {
    const char* const found = detail::simd_obstacle(volume_of(puffs(apart), s));
    return std::string(found != nullptr ? found : "");
  };
  EXPECT_EQ(obstacle({kFar, 0, 0}), "");
  EXPECT_NE(obstacle({16 * 1024, 0, 0}).find("16 000 voxels"), std::string::npos);
  EXPECT_EQ(obstacle({1600, 1600, 1600}), "");
  EXPECT_NE(obstacle({4800, 4800, 4800}).find("leaves"), std::string::npos);
}

}  // namespace long_volumes_test
}  // namespace pvol::test
