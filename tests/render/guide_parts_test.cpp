// Parts of what paths share: their setup, rays of the camera, rows of importance.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "render/guide/importance.h"
#include "render/path/camera_rays.h"
#include "support/bodies.h"

namespace pvol::test {
namespace guide_parts_test {

using Row = detail::Importance::Row;

/// The same in all directions.
Row flat(float value) {
  Row row;
  row.at.fill(value);
  return row;
}

/// A setup for a picture of one pixel, before a sky of radiance 1, which next-event estimation
/// leaves out.
class OnePixel : public testing::Test {
 protected:
  [[nodiscard]] detail::PathSetup setup(std::vector<Light> lights = {}) {
    CloudScene s{{}, ConstantSky{Rgb(1.0f)}, std::move(lights), {}, {}};
    s.options.width = s.options.height = 1;
    s.options.look_up = LookUp::nearest;
    s.options.filter = PixelFilter::box;
    volumes_ = make_volumes(cube(), std::vector{s.medium}, s);
    s.camera = frame(volumes_.front().density.world_box, 1);
    return detail::PathSetup(plan(volumes_, s.scene()));
  }

 private:
  std::vector<Volume> volumes_;
};

/// So the number of shadow rays does not hang on the unit of light.
TEST_F(OnePixel, ATenthOfTheLightIsWorthAShadowRay) {
  EXPECT_EQ(setup().light.shadow_unit, 0);
  EXPECT_NEAR(setup({Sun{{0, 1, 0}, Rgb(3.0f), 0}}).light.shadow_unit, 0.3, 1e-6);
  EXPECT_NEAR(setup({Sun{{0, 1, 0}, Rgb(3e-6f), 0}}).light.shadow_unit, 3e-7, 1e-12);
}

/// All over its pixel, and nowhere else.
TEST_F(OnePixel, CameraRaysBeginInTheirPixel) {
  const detail::PathSetup s = setup();
  const detail::Projection& p = s.view.projection;
  const Vec3d forward = p.ray(0.5, 0.5).d;  // the middle of the one pixel
  const auto in_plane = [&](Vec3d d) { return d / dot(d, forward); };
  const Vec3d corner = in_plane(p.ray(0, 0).d);
  const Vec3d right = in_plane(p.ray(1, 0).d) - corner, below = in_plane(p.ray(0, 1).d) - corner;
  proof::Histogram across(8), down(8);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Vec3d at = in_plane(detail::camera_ray(s, {2, 5, i}).d) - corner;
    across.add(dot(at, right) / dot(right, right) - 2);
    down.add(dot(at, below) / dot(below, below) - 5);
  }
  proof::Family family;
  family.add("across", across.uniform_p_value());
  family.add("down", down.uniform_p_value());
  EXPECT_TRUE(family.passes());
}

TEST(ImportanceRow, IsLinearBetweenItsNodes) {
  constexpr int kLast = detail::kDirectionNodes - 1;
  std::vector<Row> rows(2, flat(std::numeric_limits<float>::quiet_NaN()));  // nothing of the next
  for (int i = 0; i <= kLast; ++i) rows[0].at[std::size_t(i)] = float(i * i);
  for (int i = 0; i <= kLast; ++i) {
    EXPECT_NEAR(rows[0].of(float(i) / kLast), i * i, 1e-3) << i;
    if (i == kLast) break;
    const float half = 0.5f * float(i * i + (i + 1) * (i + 1));
    EXPECT_NEAR(rows[0].of((float(i) + 0.5f) / kLast), half, 1e-3) << i;
  }
}

TEST(CoarseCells, HaveTheRowOfTheCubeAroundACell) {
  detail::CoarseCells cells;
  cells.low = Int4{1, 2, 3, 0};
  cells.last = Int4{1, 0, 2, 0};
  cells.size = Vec3i(2, 1, 3);
  cells.rows = {10, 11, 12, 13, 14, 15};
  EXPECT_EQ(cells.row(Int4{8, 16, 24, 0}), 10u);
  EXPECT_EQ(cells.row(Int4{15, 23, 32, 0}), 11u);
  EXPECT_EQ(cells.row(Int4{16, 23, 31, 0}), 13u);
  EXPECT_EQ(cells.row(Int4{23, 16, 47, 0}), 15u);
  EXPECT_EQ(cells.row(Int4{0, 99, 99, 0}), 12u);  // the nearest
}

}  // namespace guide_parts_test
}  // namespace pvol::test
