// Cameras: the rays of every kind against the formulas of other programs, lenses, and frames.
#include "pvol/render/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "render/path/camera_rays.h"
#include "render/scene/projection.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"

namespace pvol::test {
namespace camera_test {

using detail::Projection;

constexpr double kDegree = std::numbers::pi / 180;

/// A camera that is turned about all axes, at (3, -7, 2), as Blender prints its matrix_world.
struct Turned {
  Vec3d x, y, z, place{3, -7, 2};

  Turned() {
    z = normalize(Vec3d(0.4, -0.8, 0.3));  // away from what it sees
    x = normalize(cross(Vec3d(0.1, 0.2, 1), z));
    y = cross(z, x);
  }
  [[nodiscard]] std::array<double, 16> rows() const {
    return {x.x, y.x, z.x, place.x, x.y, y.y, z.y, place.y, x.z, y.z, z.z, place.z, 0, 0, 0, 1};
  }
  [[nodiscard]] std::array<double, 16> columns() const {
    return {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, place.x, place.y, place.z, 1};
  }
  [[nodiscard]] Vec3d to_world(Vec3d camera) const {
    return place + x * camera.x + y * camera.y + z * camera.z;
  }
};

/// Distance of a point from a ray.
double miss(const Ray& ray, Vec3d p) {
  const Vec3d way = p - ray.o;
  return length(way - ray.d * dot(way, ray.d));
}

/// Where Blender shows a point of the camera's space, in pixels from the top left
/// (bpy_extras.object_utils.world_to_camera_view; the sensor fits the longer side).
std::array<double, 2> in_blender(Vec3d p, double lens, double sensor, std::array<double, 2> shift,
                                 int width, int height) {
  const double longer = std::max(width, height);
  const double u = lens * p.x / -p.z / sensor - shift[0];
  const double v = lens * p.y / -p.z / sensor - shift[1];
  return {width / 2.0 + u * longer, height / 2.0 - v * longer};
}

TEST(Camera, IsThatOfBlender) {
  const Turned t;
  Rng rng(1, 0, 0);
  for (const auto& [width, height] : {std::pair(640, 360), std::pair(300, 500)}) {
    for (const std::array<double, 2> shift : {std::array{0.0, 0.0}, std::array{0.2, -0.35}}) {
      Camera c{.focal_length = 55, .sensor = 32, .shift = shift};
      ASSERT_TRUE(place(c, t.rows()));
      const Projection projection(c, width, height);
      for (int i = 0; i < 200; ++i) {
        const auto [a, b, d, spare] = rng.uniform4();
        const Vec3d p(4 * double(a) - 2, 4 * double(b) - 2, -1 - 9 * double(d));
        const auto [px, py] = in_blender(p, 55, 32, shift, width, height);
        EXPECT_LT(miss(projection.ray(px, py), t.to_world(p)), 1e-9 * length(p));
      }
    }
  }
}

/// Its aperture is always across; with the fit that says so.
TEST(Camera, IsThatOfHoudini) {
  const Turned t;
  Camera rows, columns;
  ASSERT_TRUE(place(rows, t.rows()));
  ASSERT_TRUE(place(columns, t.columns()));
  EXPECT_EQ(rows, columns);
  Camera c{.focal_length = 50, .sensor = 41.4214, .fit = SensorFit::horizontal};
  ASSERT_TRUE(place(c, t.columns()));
  const Projection tall(c, 300, 500);
  const Vec3d edge(0.5 * 41.4214 / 50, 0, -1);  // on the right edge, in the middle
  EXPECT_LT(miss(tall.ray(300, 250), t.to_world(edge)), 1e-12);
  c.fit = SensorFit::vertical;
  const Vec3d top(0, 0.5 * 41.4214 / 50, -1);
  EXPECT_LT(miss(Projection(c, 300, 500).ray(150, 0), t.to_world(top)), 1e-12);
}

TEST(Camera, OfNoOtherPlaceLooksAlongMinusZWithYUp) {
  const Camera c;
  EXPECT_EQ(c.position, Vec3d(0, 0, 0));
  EXPECT_EQ(c.target, Vec3d(0, 0, -1));
  EXPECT_EQ(c.up, Vec3d(0, 1, 0));
  EXPECT_EQ(CameraPlace{}.target, c.target);
  EXPECT_EQ(CameraPlace{}.up, c.up);
}

TEST(Camera, OddMatricesAreRefused) {
  const Turned t;
  Camera c;
  std::array<double, 16> m = t.rows();
  m[15] = 2;
  EXPECT_FALSE(place(c, m));
  m = t.rows(), m[12] = 0.1;
  EXPECT_FALSE(place(c, m)) << "a projection";
  m = t.rows();
  for (const std::size_t i : {0u, 4u, 8u}) m[i] = -m[i];
  EXPECT_FALSE(place(c, m)) << "mirrored";
  for (const std::size_t i : {0u, 4u, 8u}) m[i] = 0;
  EXPECT_FALSE(place(c, m)) << "flat";
  EXPECT_EQ(c, Camera{});
  m = t.rows();
  for (std::size_t i = 0; i < 12; ++i) m[i] *= i % 4 == 3 ? 1 : 2.5;
  Camera scaled, plain;
  ASSERT_TRUE(place(scaled, m));
  ASSERT_TRUE(place(plain, t.rows()));
  EXPECT_LT(length(scaled.target - plain.target), 1e-15) << "scales do not count";
}

Camera looking(Vec3d from, Vec3d at) {
  Camera c;
  c.position = from, c.target = at;
  return c;
}

TEST(Camera, OrthographicRaysAreParallel) {
  Camera c = looking({1, 2, 30}, {1, 2, 0});
  c.kind = CameraKind::orthographic;
  c.ortho_scale = 8;
  const Projection p(c, 400, 200);
  const Ray corner = p.ray(0, 0), middle = p.ray(200, 100), side = p.ray(400, 100);
  for (const Ray& r : {corner, middle, side}) EXPECT_LT(length(r.d - Vec3d(0, 0, -1)), 1e-15);
  EXPECT_LT(length(corner.o - Vec3d(-3, 4, 30)), 1e-12);
  EXPECT_LT(length(middle.o - Vec3d(1, 2, 30)), 1e-12);
  EXPECT_LT(length(side.o - Vec3d(5, 2, 30)), 1e-12);
  c.shift = {0.25, 0.125};
  EXPECT_LT(length(Projection(c, 400, 200).ray(200, 100).o - Vec3d(3, 3, 30)), 1e-12);
}

TEST(Camera, LatlongSeesAllDirections) {
  Camera c = looking({0, 0, 0}, {0, 0, -1});
  c.kind = CameraKind::latlong;
  const Projection p(c, 400, 200);
  const auto at = [&](double x, double y) { return p.ray(x, y).d; };
  EXPECT_LT(length(at(200, 100) - Vec3d(0, 0, -1)), 1e-12);
  EXPECT_LT(length(at(300, 100) - Vec3d(1, 0, 0)), 1e-12);
  EXPECT_LT(length(at(100, 100) - Vec3d(-1, 0, 0)), 1e-12);
  EXPECT_LT(length(at(0, 100) - Vec3d(0, 0, 1)), 1e-12);
  EXPECT_LT(length(at(123, 0) - Vec3d(0, 1, 0)), 1e-12);
  EXPECT_LT(length(at(200, 50) - normalize(Vec3d(0, 1, -1))), 1e-12);
}

/// 50 mm at f/2 is a lens of 12.5 mm radius.
TEST(Lens, HasTheRadiusOfItsFocalLength) {
  Camera c{.focal_length = 50, .f_stop = 2};
  EXPECT_NEAR(lens_radius(c, 1.5), 0.0125, 1e-15);
  c.metres = 0.01;  // centimetres
  EXPECT_NEAR(lens_radius(c, 1.5), 1.25, 1e-12);
  c.focal_length.reset();
  c.fov = 2 * std::atan(24 / 2.0 / 50) / kDegree;  // 36 mm across 24
  EXPECT_NEAR(lens_radius(c, 1.5), 1.25, 1e-12);
  c.f_stop.reset();
  EXPECT_EQ(lens_radius(c, 1.5), 0);
}

TEST(Lens, RaysOfAPixelMeetWhereItIsSharp) {
  Camera c = looking({1, 2, 3}, {4, 3, -5});
  c.f_stop = 1.4, c.metres = 0.01, c.shift = {0.1, 0};
  const double radius = lens_radius(c, 2);
  const Vec3d forward = normalize(c.target - c.position);
  proof::Histogram turns(16), areas(16);
  for (const double focus : {0.0, 5.0}) {
    if (focus > 0) c.focus_distance = focus;
    const double distance = focus > 0 ? focus : length(c.target - c.position);
    const Projection p(c, 40, 20);
    const Ray middle = p.ray(13.2, 4.7);
    const Vec3d sharp = middle.at(distance / dot(middle.d, forward));
    const Vec3d x = normalize(cross(forward, c.up)), y = cross(forward, x);
    Rng rng(proof::seeded(2), std::uint64_t(focus), 0);
    for (int i = 0; i < 4000; ++i) {
      const auto [u, v] = rng.uniform2();
      const Ray ray = p.ray(13.2, 4.7, u, v);
      ASSERT_LT(miss(ray, sharp), 1e-12);
      const Vec3d on = ray.o - c.position;
      EXPECT_NEAR(dot(on, forward), 0, 1e-14);
      const double a = dot(on, x), b = dot(on, y);
      turns.add(std::atan2(b, a) / (2 * std::numbers::pi) + 0.5);
      areas.add((a * a + b * b) / (radius * radius));
    }
  }
  proof::Family family;
  family.add("around", turns.uniform_p_value());
  family.add("outward", areas.uniform_p_value());
  EXPECT_TRUE(family.passes());
}

/// A small cube far behind where it is sharp is a disc of the lens' own shape: its picture's
/// spread is that of one.
TEST(Lens, BlursAsFarAsItShould) {
  for (const double f_stop : {2.0, 4.0}) {
    CloudScene s;
    s.medium = component(1e3, Rgb(0.0f), 0);
    s.medium.object_to_world = translation({-0.3, -0.3, -0.3}) * scaling(Vec3d(0.05));
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights.clear();
    s.camera = looking({0, 0, 40}, {0, 0, 0});
    s.camera.fov = 12;
    s.camera.f_stop = f_stop, s.camera.metres = 0.02, s.camera.focus_distance = 20;
    s.options.look_up = LookUp::nearest;
    s.options.width = s.options.height = 48;
    s.options.samples = 1024;
    const std::vector<Volume> v = make_volumes(cube(), std::vector{s.medium}, s);
    const Film film = render(v, s).film;
    double sum = 0, squares = 0;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        const double a = double(film.at(x, y).alpha);
        sum += a, squares += a * (std::pow(x - 23.5, 2) + std::pow(y - 23.5, 2));
      }
    }
    // In pixels of the plane at 40 units; the cube's own spread and that of pixels besides.
    const double pixel = 2 * 40 * std::tan(6 * kDegree) / 48;
    const double blur = lens_radius(s.camera, 1) * (40.0 - 20) / 20 / pixel;
    const double own = 2 * std::pow(0.65 / pixel, 2) / 12, of_pixels = 2.0 / 12;
    EXPECT_NEAR(squares / sum / (blur * blur / 2 + own + of_pixels), 1, 0.02) << f_stop;
  }
}

TEST(Camera, EveryKindSeesTheFurnace) {
  for (const CameraKind kind :
       {CameraKind::perspective, CameraKind::orthographic, CameraKind::latlong}) {
    for (const bool lens : {false, true}) {
      if (lens && kind != CameraKind::perspective) continue;
      CloudScene s;
      s.medium = component(0.3, Rgb(1.0f), 0.3);
      s.environment = ConstantSky{Rgb(1.0f)};
      s.lights.clear();
      s.camera.kind = kind;
      if (lens) s.camera.f_stop = 2, s.camera.metres = 0.01;
      s.options.width = 24, s.options.height = 12, s.options.samples = 16;
      const std::vector<Volume> v = make_volumes(cube(), std::vector{s.medium}, s);
      s.camera = frame(v.front().density.world_box, 2, s.camera);
      const Film film = render(v, s).film;
      double alpha = 0;
      for (const PixelSums& p : film.pixels) {
        EXPECT_NEAR(mean(p).x, 1, 1e-4);
        alpha += double(p.alpha);
      }
      EXPECT_GT(alpha, 0) << name(kind);
    }
  }
}

/// Where a point is in the picture, from -1 to 1, by a search over the camera's rays.
std::array<double, 2> in_picture(const Camera& c, double aspect, Vec3d p) {
  const Vec3d forward = normalize(c.target - c.position);
  const Vec3d x = normalize(cross(forward, c.up)), y = cross(x, forward);
  const Vec3d way = p - c.position;
  const double depth = c.kind == CameraKind::orthographic ? 1 : dot(way, forward);
  const double height = half_height(c, aspect);
  return {dot(way, x) / depth / height / aspect, dot(way, y) / depth / height};
}

TEST(Frame, FillsThePictureFromEverywhere) {
  const Box box{{-3, 1, 4}, {5, 2, 30}};
  for (const CameraKind kind : {CameraKind::perspective, CameraKind::orthographic}) {
    for (const double aspect : {0.5, 1.0, 2.4}) {
      for (const Vec3d up : {Vec3d(0, 1, 0), Vec3d(0, 0, 1)}) {
        for (const auto& [azimuth, elevation] :
             {std::pair(0.0, 0.0), std::pair(90.0, 0.0), std::pair(30.0, 20.0),
              std::pair(0.0, 90.0), std::pair(45.0, -90.0)}) {
          Camera like;
          like.kind = kind, like.up = up, like.azimuth = azimuth, like.elevation = elevation;
          const Camera c = frame(box, aspect, like);
          double most = 0;
          for (int i = 0; i < 8; ++i) {
            const Vec3d p(i & 1 ? box.lo.x : box.hi.x, i & 2 ? box.lo.y : box.hi.y,
                          i & 4 ? box.lo.z : box.hi.z);
            const auto [x, y] = in_picture(c, aspect, p);
            most = std::max({most, std::abs(x), std::abs(y)});
          }
          EXPECT_NEAR(most, 1 / 1.08, 1e-9) << name(kind) << aspect << up.z << azimuth << elevation;
          EXPECT_TRUE(c.azimuth == 0 && !c.elevation && c.zoom == 1) << "they are done";
          EXPECT_FALSE(misfit(c));
        }
      }
    }
  }
}

TEST(Frame, ViewsHaveTheirNames) {
  const Box box{{-1, -1, -1}, {1, 1, 1}};
  const auto from = [&](double azimuth, double elevation) {
    Camera like;
    like.azimuth = azimuth, like.elevation = elevation;
    const Camera c = frame(box, 1, like);
    return normalize(c.position - c.target);
  };
  EXPECT_LT(length(from(0, 0) - Vec3d(0, 0, 1)), 1e-12);
  EXPECT_LT(length(from(90, 0) - Vec3d(1, 0, 0)), 1e-12);
  EXPECT_LT(length(from(180, 0) - Vec3d(0, 0, -1)), 1e-12);
  EXPECT_LT(length(from(-90, 0) - Vec3d(-1, 0, 0)), 1e-12);
  EXPECT_LT(length(from(0, 90) - Vec3d(0, 1, 0)), 1e-12);
  EXPECT_LT(length(from(90, 30) - Vec3d(std::cos(30 * kDegree), 0.5, 0)), 1e-12);
  Camera top;
  top.elevation = 90;
  EXPECT_LT(length(frame(box, 1, top).up - Vec3d(0, 0, -1)), 1e-12) << "the front is down";
}

TEST(Frame, ZoomMakesItAsMuchLarger) {
  const Box box{{-1, -1, -1}, {1, 1, 1}};
  for (const CameraKind kind : {CameraKind::perspective, CameraKind::orthographic}) {
    for (const bool lens : {false, true}) {
      Camera like;
      like.kind = kind;
      if (lens) like.focal_length = 35;
      const Camera plain = frame(box, 1.5, like);
      like.zoom = 3;
      const Camera near = frame(box, 1.5, like);
      EXPECT_LT(length(near.position - plain.position), 1e-12);
      EXPECT_NEAR(half_height(plain, 1.5) / half_height(near, 1.5), 3, 1e-12);
    }
  }
}

TEST(Camera, WhatDoesNotGoTogetherIsRefused) {
  Camera c;
  c.kind = CameraKind::orthographic;
  c.f_stop = 2;
  EXPECT_NE(error_of([&] { validate(c); }).find("f_stop"), std::string::npos);
  c.f_stop.reset();
  EXPECT_NO_THROW(validate(c));
  c.kind = CameraKind::latlong;
  c.shift = {0.1, 0};
  EXPECT_NE(error_of([&] { validate(c); }).find("shift"), std::string::npos);
}

/// Any 2^k points from a multiple of 2^k on have one in each box of 2^-i by 2^(i-k).
TEST(Sequences, HaveOnePointInEachBox) {
  const std::array<std::uint32_t, 3> seeds[] = {{0, 0, 0}, {1, 2, 3}, {0xdeadbeef, 77, 0x12345678}};
  for (const auto& seed : seeds) {
    for (int k = 0; k <= 6; ++k) {
      const std::uint32_t count = 1u << k;
      for (const std::uint32_t first : {0u, count, 13 * count}) {
        for (int i = 0; i <= k; ++i) {
          std::set<std::pair<int, int>> boxes;
          for (std::uint32_t n = first; n < first + count; ++n) {
            const auto [x, y] = detail::point_of_square(n, seed);
            ASSERT_TRUE(x >= 0 && x < 1 && y >= 0 && y < 1);
            boxes.emplace(int(x * float(1 << i)), int(y * float(1 << (k - i))));
          }
          EXPECT_EQ(boxes.size(), count) << k << ' ' << i;
        }
      }
    }
  }
}

/// Over seeds, points and pairs of points are uniform.
TEST(Sequences, AreUniformOverTheirSeeds) {
  proof::Family family;
  for (const std::uint32_t index : {0u, 1u, 5u, 1023u}) {
    proof::Histogram x(32), y(32), between(32);
    for (std::uint64_t i = 0; i < 20'000; ++i) {
      const auto seeds = [&](std::uint64_t key) {
        const Philox::Block b = Rng(key, i, 0).block();
        return std::array{std::uint32_t(b.lo), std::uint32_t(b.lo >> 32), std::uint32_t(b.hi)};
      };
      const auto p = detail::point_of_square(index, seeds(7));
      const auto q = detail::point_of_square(index, seeds(8));
      x.add(double(p[0])), y.add(double(p[1]));
      const double d = double(p[0]) - double(q[1]);
      between.add(d - std::floor(d));
    }
    family.add("x", x.uniform_p_value());
    family.add("y", y.uniform_p_value());
    family.add("between", between.uniform_p_value());
  }
  EXPECT_TRUE(family.passes());
}

/// Of each kind: all of it within its width, its moments, and where half of one side lies.
TEST(PixelFilters, HaveTheirShape) {
  struct Case {
    PixelFilter filter;
    double variance;  ///< over the squared width
  };
  // A Gaussian of a sixth of the width, cut at three deviations; Blackman-Harris by its integral.
  const auto variance_of = [](const auto& weight) {
    double sum = 0, squares = 0;
    for (int i = 0; i < 1000; ++i) {
      const double x = (i + 0.5) / 1000 - 0.5;
      sum += weight(x), squares += x * x * weight(x);
    }
    return squares / sum;
  };
  const double turn = 2 * std::numbers::pi;
  const Case cases[] = {
      {PixelFilter::box, 1.0 / 12},
      {PixelFilter::gaussian, variance_of([](double x) { return std::exp(-18 * x * x); })},
      {PixelFilter::blackman_harris, variance_of([&](double x) {
         return 0.35875 + 0.48829 * std::cos(turn * x) + 0.14128 * std::cos(2 * turn * x) +
                0.01168 * std::cos(3 * turn * x);
       })},
  };
  for (const Case& c : cases) {
    for (const double width : {1.0, 3.0}) {
      const detail::FilterOffsets offset(c.filter, width);
      constexpr int kCount = 1'000'000;
      double sum = 0, squares = 0, most = 0;
      for (int i = 0; i < kCount; ++i) {
        const auto x = double(offset(float(i) / kCount));
        sum += x, squares += x * x, most = std::max(most, std::abs(x));
      }
      EXPECT_NEAR(sum / kCount, 0, 1e-5 * width) << name(c.filter);
      EXPECT_NEAR(squares / kCount / (c.variance * width * width), 1, 1e-3) << name(c.filter);
      EXPECT_LE(most, width / 2);
      EXPECT_GT(most, 0.49 * width);
    }
  }
}

/// A thin picture of a cube that is much smaller than a pixel is the filter itself.
TEST(PixelFilters, AreWhatPicturesShow) {
  for (const PixelFilter filter :
       {PixelFilter::box, PixelFilter::gaussian, PixelFilter::blackman_harris}) {
    CloudScene s;
    s.medium = component(1e4, Rgb(0.0f), 0);
    s.medium.object_to_world = translation({-0.18, -0.18, 0}) * scaling(Vec3d(0.03));
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights.clear();
    s.camera = looking({0, 0, 40}, {0, 0, 0});
    s.camera.kind = CameraKind::orthographic, s.camera.ortho_scale = 12;
    s.options.look_up = LookUp::nearest;
    s.options.filter = filter, s.options.filter_width = 4;
    s.options.width = s.options.height = 12;
    s.options.samples = 1 << 14;
    const std::vector<Volume> v = make_volumes(cube(), std::vector{s.medium}, s);
    const Film film = render(v, s).film;
    // Middles of pixels lie half a pixel off the cube's.
    const auto alpha = [&](int x, int y) { return double(film.at(x, y).alpha); };
    double sum = 0;
    for (const PixelSums& p : film.pixels) sum += double(p.alpha);
    EXPECT_NEAR(alpha(5, 5) / alpha(6, 6), 1, 0.2);
    EXPECT_EQ(alpha(3, 3), 0) << "two and a half pixels away";
    if (filter != PixelFilter::box) {
      EXPECT_GT(alpha(5, 5), 2 * alpha(4, 5));
    }
    const double mass = sum / (1 << 14);
    EXPECT_NEAR(mass / (0.39 * 0.39), 1, 0.03) << "light is neither lost nor made";
  }
}

TEST(Camera, SeesPlacesWhereItsRaysShowThem) {
  const Turned t;
  Rng rng(2, 0, 0);
  for (const CameraKind kind :
       {CameraKind::perspective, CameraKind::orthographic, CameraKind::latlong}) {
    Camera c{.kind = kind, .shift = {0.2, -0.1}, .ortho_scale = 3};
    ASSERT_TRUE(place(c, t.rows()));
    const Projection p(c, 300, 200);
    for (int i = 0; i < 200; ++i) {
      const double x = 300 * double(rng.uniform()), y = 200 * double(rng.uniform());
      const double depth = 0.5 + 9 * double(rng.uniform());
      const Vec3d place = p.place(x, y, depth);
      ASSERT_LT(miss(p.ray(x, y), place), 1e-9);
      ASSERT_NEAR(p.depth(place), depth, 1e-9);
      const auto seen = p.seen(place);
      ASSERT_TRUE(seen);
      ASSERT_NEAR((*seen)[0], x, 1e-6);
      ASSERT_NEAR((*seen)[1], y, 1e-6);
    }
    EXPECT_EQ(p.seen(t.place + t.z).has_value(), kind == CameraKind::latlong) << "behind";
  }
}

TEST(Camera, KnowsTheDepthsOfBoxes) {
  const Turned t;
  Rng rng(3, 0, 0);
  for (const CameraKind kind :
       {CameraKind::perspective, CameraKind::orthographic, CameraKind::latlong}) {
    Camera c{.kind = kind};
    ASSERT_TRUE(place(c, t.rows()));
    const Projection p(c, 30, 20);
    for (const Vec3d at : {t.place - t.z * 9.0, t.place, t.place + t.z * 5.0}) {
      const Affine to_world = translation(at) * scaling({0.5, 2, 1});
      const Box box{Vec3d(-1.0), Vec3d(1.0)};
      const Span depths = p.depths(to_world, box);
      Span found{1e300, -1e300};
      for (int i = 0; i < 200'000; ++i) {
        const auto [x, y, z, spare] = rng.uniform4();
        const double depth = p.depth(to_world.point(Vec3d(Vec3f(x, y, z)) * 2.0 - Vec3d(1.0)));
        found = {std::min(found.t0, depth), std::max(found.t1, depth)};
      }
      EXPECT_LE(depths.t0, found.t0);
      EXPECT_GE(depths.t1, found.t1);
      EXPECT_NEAR(depths.t0, found.t0, 0.2);
      EXPECT_NEAR(depths.t1, found.t1, 0.2);
    }
  }
}

}  // namespace camera_test
}  // namespace pvol::test
