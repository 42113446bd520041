// Where USD's transforms put things: against products of matrices in closed form.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/error_of.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_xform_test {

using test::error_of;
using test::read_usda_text;
using test::usd_cloud;
using test::usda_notes;
using test::usda_text;

/// A map as USD has it: rows are multiplied by it from the left, its last row is the translation.
using Rows = std::array<std::array<double, 4>, 4>;

Rows times(const Rows& a, const Rows& b) {
  Rows c{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

Rows moved(double x, double y, double z) {
  return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {x, y, z, 1}}};
}
Rows scaled(double x, double y, double z) {
  return {{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}, {0, 0, 0, 1}}};
}
/// Against the clock, as seen from the tip of the axis.
Rows turned(int axis, double degrees) {
  const double c = std::cos(degrees / 180 * std::numbers::pi);
  const double s = std::sin(degrees / 180 * std::numbers::pi);
  if (axis == 0) return {{{1, 0, 0, 0}, {0, c, s, 0}, {0, -s, c, 0}, {0, 0, 0, 1}}};
  if (axis == 1) return {{{c, 0, -s, 0}, {0, 1, 0, 0}, {s, 0, c, 0}, {0, 0, 0, 1}}};
  return {{{c, s, 0, 0}, {-s, c, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
}

Vec3d row_times(Vec3d p, const Rows& m) {
  Vec3d q;
  for (int j = 0; j < 3; ++j) {
    const auto c = std::size_t(j);
    q[j] = p.x * m[0][c] + p.y * m[1][c] + p.z * m[2][c] + m[3][c];
  }
  return q;
}

std::string order_of(const std::string& names) {
  return "uniform token[] xformOpOrder = [" + names + "]\n";
}

/// Where the volume within a prim of these lines goes.
Affine place_of(const std::string& lines) {
  const ImportedScene s =
      read_usda_text(usda_text("def Xform \"it\"\n{\n" + lines + usd_cloud("/it") + "}\n", "", ""));
  return s.file.volumes.at(0).object_to_world;
}

void expect_map(const std::string& lines, const Rows& expected) {
  const Affine map = place_of(lines);
  for (const Vec3d p : {Vec3d{0, 0, 0}, {1, 0, 0}, {0.3, -2, 0.7}}) {
    EXPECT_LT(length(map.point(p) - row_times(p, expected)), 1e-12) << lines;
  }
}

TEST(UsdaXform, OperationsAreAppliedFromTheLastToTheFirst) {
  expect_map(
      "double3 xformOp:translate = (1, 2, 3)\nfloat xformOp:rotateY = 30\n"
      "float3 xformOp:scale = (2, 3, 4)\n" +
          order_of("\"xformOp:translate\", \"xformOp:rotateY\", \"xformOp:scale\""),
      times(times(scaled(2, 3, 4), turned(1, 30)), moved(1, 2, 3)));
  expect_map("double xformOp:translateX = 1\ndouble xformOp:scaleZ = 2\n" +
                 order_of("\"xformOp:scaleZ\", \"xformOp:translateX\""),
             times(moved(1, 0, 0), scaled(1, 1, 2)));
}

TEST(UsdaXform, ThreeTurnsInEveryOrder) {
  const std::string axes = "XYZ";
  const std::array<double, 3> angle{20, -35, 70};
  for (const std::string order : {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"}) {
    Rows all = scaled(1, 1, 1);
    for (const char a : order) {
      all = times(all, turned(int(axes.find(a)), angle[axes.find(a)]));
    }
    const std::string name = "xformOp:rotate" + order;
    expect_map("float3 " + name + " = (20, -35, 70)\n" + order_of('"' + name + '"'), all);
  }
}

TEST(UsdaXform, QuaternionsHaveTheirRealPartFirst) {
  const double half = 40.0 / 180 * std::numbers::pi;
  const std::string q =
      "(" + std::to_string(std::cos(half)) + ", 0, 0, " + std::to_string(std::sin(half)) + ")";
  const ImportedScene s =
      read_usda_text(usda_text("def Camera \"c\" { quatf xformOp:orient = " + q + "\n" +
                               order_of("\"xformOp:orient\"") + "}"));
  // Turned by 80 degrees about z: up goes from +y towards -x.
  const double turn = 2 * half;
  EXPECT_LT(length(s.file.scene.camera.up - Vec3d{-std::sin(turn), std::cos(turn), 0}), 1e-5);
}

/// Of any length: each of its four numbers counts.
TEST(UsdaXform, QuaternionsMayHaveAnyLength) {
  for (const double scale : {1.0, 0.1, 7.0}) {
    const auto up = [&](double w, double x, double y, double z) {
      const std::string q =
          fmt::format("({}, {}, {}, {})", scale * w, scale * x, scale * y, scale * z);
      const ImportedScene s =
          read_usda_text(usda_text("def Camera \"c\" { quatf xformOp:orient = " + q + "\n" +
                                   order_of("\"xformOp:orient\"") + "}"));
      return s.file.scene.camera.up;
    };
    // By a third of a circle about (1, 1, 1): y becomes z, as by half of one about (0, 1, 1).
    EXPECT_LT(length(up(0.5, 0.5, 0.5, 0.5) - Vec3d(0, 0, 1)), 1e-5) << scale;
    EXPECT_LT(length(up(0, 0, 1, 1) - Vec3d(0, 0, 1)), 1e-5) << scale;
    EXPECT_LT(length(up(3, 4, 0, 0) - Vec3d(0, -0.28, 0.96)), 1e-5) << scale;
  }
}

TEST(UsdaXform, QuaternionsOfLengthZeroTurnNothing) {
  expect_map("quatf xformOp:orient = (0, 0, 0, 0)\ndouble3 xformOp:translate = (1, 2, 3)\n" +
                 order_of("\"xformOp:translate\", \"xformOp:orient\""),
             moved(1, 2, 3));
}

TEST(UsdaXform, MatricesHaveTheTranslationInTheLastRow) {
  const Rows m{{{0, 2, 0, 0}, {-1, 0, 0, 0}, {0, 0.5, 3, 0}, {7, 8, 9, 1}}};
  expect_map(
      "matrix4d xformOp:transform = ((0, 2, 0, 0), (-1, 0, 0, 0), (0, 0.5, 3, 0), "
      "(7, 8, 9, 1))\n" +
          order_of("\"xformOp:transform\""),
      m);
}

TEST(UsdaXform, InvertedPivots) {
  expect_map("double3 xformOp:translate:pivot = (1, 2, 3)\nfloat xformOp:rotateZ = 90\n" +
                 order_of("\"xformOp:translate:pivot\", \"xformOp:rotateZ\", "
                          "\"!invert!xformOp:translate:pivot\""),
             times(times(moved(-1, -2, -3), turned(2, 90)), moved(1, 2, 3)));
}

TEST(UsdaXform, PrimsAreWithinEachOther) {
  const std::string move = "double3 xformOp:translate = (1, 2, 3)\n";
  const std::string order = order_of("\"xformOp:translate\"");
  const std::string inner = R"(def Volume "c" { rel field:density = </a/c/d>
    double3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = [)";
  const std::string asset = "] def OpenVDBAsset \"d\" { asset filePath = @a.vdb@ } }";
  const auto place = [&](const std::string& names) {
    const ImportedScene s = read_usda_text(
        usda_text("def \"a\" { " + move + order + inner + names + asset + "}", "", ""));
    return s.file.volumes.at(0).object_to_world;
  };
  EXPECT_EQ(place("\"xformOp:scale\"").point({1, 1, 1}), Vec3d(3, 4, 5));
  EXPECT_EQ(place("\"!resetXformStack!\", \"xformOp:scale\"").point({1, 1, 1}), Vec3d(2, 2, 2));
}

TEST(UsdaXform, WhatMovesHasAPlaceOneFrameLater) {
  const std::string text = usda_text(
      "def Sphere \"s\" { double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 5: (4, 8, 0) "
      "}\n" +
      order_of("\"xformOp:translate\"") + "}");
  const auto ball = [&](std::optional<int> frame) {
    const ImportedScene s = read_usda_text(text, frame);
    return std::get<BallSurface>(s.file.scene.surfaces.at(0));
  };
  EXPECT_EQ(ball({}).centre, Vec3d(0, 0, 0));
  EXPECT_EQ(ball({}).to, BallPlace{Vec3d(1, 2, 0)});
  EXPECT_EQ(ball(3).centre, Vec3d(2, 4, 0));
  EXPECT_EQ(ball(5).to, std::nullopt);
}

TEST(UsdaXform, BadTransformsAreRefusedAndFlatOnesNamed) {
  const auto fault = [](const std::string& lines) {
    return error_of([&] { (void)place_of(lines); });
  };
  EXPECT_TRUE(says(fault("matrix4d xformOp:transform = ((1, 0, 0, 1), (0, 1, 0, 0), (0, 0, 1, 0), "
                         "(0, 0, 0, 1))\n" +
                         order_of("\"xformOp:transform\"")),
                   "usd.perspective"));
  EXPECT_TRUE(says(fault(order_of("\"xformOp:shear\"")), "usd.unknown_operation"));
  const ImportedScene s =
      read_usda_text(usda_text("def \"a\" { float3 xformOp:scale = (1, 0, 1)\n" +
                               order_of("\"xformOp:scale\"") + "def Sphere \"s\" { } }"));
  EXPECT_EQ(s.file.scene.surfaces.size(), 0u);
  EXPECT_TRUE(says(usda_notes(s), "usd.no_inverse"));
}

}  // namespace usda_xform_test
}  // namespace pvol::formats
