// The camera that fills the picture with what volumes hold.
#include "pvol/render/frame_volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pvol/render/render.h"
#include "pvol/volume/facts.h"
#include "render/scene/projection.h"
#include "support/cloud_scene.h"
#include "support/fields.h"

namespace pvol::test {
namespace frame_test {

/// Some voxels around a line through the box, corner to corner: 64 long, with far empty corners.
const Field& rod() {
  static const Field f = make_field("rod", {0, 0, 0}, {64, 64, 64}, [](Vec3i p) {
    return std::max({std::abs(p.x - p.y), std::abs(p.y - p.z), std::abs(p.x - p.z)}) < 4 ? 1.0
                                                                                         : 0.0;
  });
  return f;
}

Volume make_rod(const Affine& place) {
  CloudScene s;
  s.medium.object_to_world = place;
  return make_volume(rod().grid, build_pyramid(rod().grid), s);
}

/// How far the corners of occupied voxels lie from the picture's middle, in half pictures.
struct Extent {
  double across = 0, down = 0;
};
Extent extent_of(const Affine& place, const Camera& c, int width, int height) {
  const detail::Projection projection(c, width, height);
  Extent most;
  for (int i = 0; i < 64; ++i) {
    for (const Vec3d off : {Vec3d(-3, 0, 0), Vec3d(0, 3, 1), Vec3d(2, -1, 1), Vec3d(1, 1, 1)}) {
      if (!Box{Vec3d(0), Vec3d(63)}.contains(Vec3d(i) + off)) continue;
      const Vec3d p = place.point(Vec3d(i) + off);
      // By the rays: the pixel whose ray passes the point.
      const Ray middle = projection.ray(width / 2.0, height / 2.0);
      const Ray right = projection.ray(width, height / 2.0), top = projection.ray(width / 2.0, 0);
      const Vec3d way = p - c.position;
      if (c.kind == CameraKind::orthographic) {
        const Vec3d x = right.o - middle.o, y = top.o - middle.o;
        most.across = std::max(most.across, std::abs(dot(p - middle.o, x)) / dot(x, x));
        most.down = std::max(most.down, std::abs(dot(p - middle.o, y)) / dot(y, y));
        continue;
      }
      const double depth = dot(way, middle.d);
      const auto share = [&](const Ray& rim) {
        const Vec3d axis = normalize(rim.d / dot(rim.d, middle.d) - middle.d);
        const double half = length(rim.d / dot(rim.d, middle.d) - middle.d);
        return std::abs(dot(way, axis)) / depth / half;
      };
      most.across = std::max(most.across, share(right));
      most.down = std::max(most.down, share(top));
    }
  }
  return most;
}

TEST(Frame, FromAslantTheCloudFillsThePicture) {
  const Affine places[] = {Affine{}, translation({100, -50, 7}) * scaling({2, 1, 0.5})};
  for (const Affine& place : places) {
    const Volume v = make_rod(place);
    for (const double azimuth : {30.0, 45.0, 135.0, -100.0}) {
      for (const double elevation : {-20.0, 10.0, 65.0}) {  // at 35 it is seen end on
        Camera like;
        like.azimuth = azimuth;
        like.elevation = elevation;
        const Camera c = frame_volumes({&v, 1}, 1.5, like);
        const Extent r = extent_of(place, c, 300, 200);
        EXPECT_LE(std::max(r.across, r.down), 1) << azimuth << ", " << elevation;
        EXPECT_GE(std::max(r.across, r.down), 0.7) << azimuth << ", " << elevation;
        const Camera by_box = frame(still_world_box({&v, 1}), 1.5, like);
        const Extent b = extent_of(place, by_box, 300, 200);
        EXPECT_GE(std::max(r.across, r.down), 0.99 * std::max(b.across, b.down));
      }
    }
  }
  // Along the rod's own direction in plan the box is 1.7 times as wide as what it holds.
  const Volume v = make_rod({});
  Camera like;
  like.azimuth = 45;
  like.elevation = 10;
  const double near = length(frame_volumes({&v, 1}, 1, like).position - Vec3d(32));
  const double far = length(frame(still_world_box({&v, 1}), 1, like).position - Vec3d(32));
  EXPECT_LT(near, 0.9 * far);
}

TEST(Frame, OrthographicAndZoomedCamerasFillIt) {
  const Volume v = make_rod({});
  Camera like;
  like.azimuth = -45;
  like.elevation = 20;
  like.kind = CameraKind::orthographic;
  for (const double zoom : {1.0, 2.0}) {
    like.zoom = zoom;
    const Extent r = extent_of({}, frame_volumes({&v, 1}, 1.5, like), 300, 200);
    EXPECT_LE(std::max(r.across, r.down), zoom);
    EXPECT_GE(std::max(r.across, r.down), 0.75 * zoom);
  }
  like.kind = CameraKind::perspective;
  const Extent r = extent_of({}, frame_volumes({&v, 1}, 1.5, like), 300, 200);
  EXPECT_GE(std::max(r.across, r.down), 0.75 * 2);
}

TEST(Frame, FromTheFrontItIsThatOfTheBox) {
  const Volume v = make_rod({});
  const Camera a = frame_volumes({&v, 1}, 1.5), b = frame(still_world_box({&v, 1}), 1.5);
  EXPECT_EQ(a, b);
}

TEST(Frame, ManyPlacesAreAllSeen) {
  CloudScene s;
  VolumeOptions o = s.volume_options();
  for (int i = 0; i < 100; ++i) o.instances.push_back(translation({i * 70.0, 0, (i % 7) * 90.0}));
  const Volume v = pvol::make_volume(rod().grid, build_pyramid(rod().grid), s.medium.medium(), o);
  Camera like;
  like.azimuth = 60;
  like.elevation = 30;
  const Camera c = frame_volumes({&v, 1}, 1.5, like);
  const detail::Projection projection(c, 300, 200);
  for (const Affine& place : o.instances) {
    const Extent r = extent_of(place, c, 300, 200);
    EXPECT_LE(std::max(r.across, r.down), 1);
  }
}

}  // namespace frame_test
}  // namespace pvol::test
