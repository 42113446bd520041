// Colours by which albedos vary: what they are at each place, and what cannot be.
#include "pvol/volume/albedo_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/bounds/pyramid.h"
#include "pvol/volume/make_volume.h"
#include "support/colors.h"
#include "support/error_of.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace albedo_field_test {

Rgb slope(Vec3d p) { return {float(0.1 + p.x / 40), float(0.9 - p.y / 50), float(0.3 + p.z / 60)}; }

void expect_color(Rgb found, Rgb wanted, float tolerance, const std::string& where) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], tolerance) << where << ' ' << c;
}

TEST(AlbedoField, IsTrilinearInItsOwnPlace) {
  // A linear function is its own interpolation, in voxels of 0.5 that are moved and turned.
  const Affine map = translation({3, -2, 1}) * scaling(Vec3d(0.5));
  const Affine place{{Vec3d{0, 2, 0}, Vec3d{-2, 0, 0}, Vec3d{0, 0, 2}}, {5, 6, 7}};
  const ColorGrid colors = make_colors(
      {-4, 0, 3}, {20, 20, 20}, [](Vec3i p) { return slope(Vec3d(p)); }, map);
  const auto field = albedo_of(colors, nullptr, place);
  for (const Vec3d p : {Vec3d(-4, 0, 3), Vec3d(0.25, 7.5, 9.125), Vec3d(14.9, 18.5, 21.75)}) {
    const Vec3d world = (place * map).point(p);
    expect_color(color_at(*field, world), slope(p), 2e-6f, "in the lattice");
  }
}

TEST(AlbedoField, LeavesOutSamplesThatSayNoColour) {
  // Known for x < 8 alone: beyond the last sample the colour goes on, and beyond its cell is none.
  const Rgb red(0.8f, 0.25f, 0.0f);
  const ColorGrid colors = make_colors({0, 0, 0}, {16, 16, 16}, [&](Vec3i p) {
    return p.x < 8 ? std::optional(red) : std::nullopt;
  });
  const auto field = albedo_of(colors);
  expect_color(color_at(*field, {3.5, 4, 4}), red, 0, "inside");
  expect_color(color_at(*field, {7.75, 4, 4}), red, 1e-6f, "at the edge of what is known");
  expect_color(color_at(*field, {-0.5, -0.5, 4}), red, 1e-6f, "at the edge of the lattice");
  expect_color(color_at(*field, {8.5, 4, 4}), Rgb(1.0f), 0, "where none is known");
  expect_color(color_at(*field, {-1e9, 4, 1e6}), Rgb(1.0f), 0, "far outside");
  EXPECT_EQ(color_at(*albedo_of(ColorGrid{}), {0, 0, 0}), Rgb(1.0f)) << "no colours at all";
}

TEST(AlbedoField, KnowsBlackFromNothing) {
  const ColorGrid colors = make_colors({0, 0, 0}, {8, 8, 8}, [](Vec3i) { return Rgb(0.0f); });
  EXPECT_EQ(color_at(*albedo_of(colors), {3, 3, 3}), Rgb(0.0f));
  EXPECT_EQ(color_at(*albedo_of(colors), {12, 3, 3}), Rgb(1.0f));
}

TEST(AlbedoField, TilesAreColours) {
  ColorGrid colors;
  const std::array values{0.5f, 0.25f, 0.0f, 1.0f};
  for (std::size_t k = 0; k < 4; ++k) {
    VoxelGrid& to = k < 3 ? colors.channels[k] : colors.known;
    if (values[k] > 0) to.tiles.push_back({{128, 0, 0}, 128, values[k]});
  }
  const auto field = albedo_of(colors);
  EXPECT_EQ(color_at(*field, {200, 64, 64}), Rgb(0.5f, 0.25f, 0.0f));
  EXPECT_EQ(color_at(*field, {120, 64, 64}), Rgb(1.0f));
}

TEST(AlbedoField, NumbersAreMappedAfterInterpolation) {
  const Field f =
      make_field("temperature", {0, 0, 0}, {16, 16, 16}, [](Vec3i p) { return p.x * 100.0; });
  const Pyramid pyramid = build_pyramid(f.grid);
  AlbedoMap map{.map = {.scale = 0.001, .power = 2}};
  const AlbedoField grey = make_albedo_field(map, {f.grid, pyramid}, {});
  expect_color(color_at(grey, {7.5, 4, 4}), Rgb(0.5625f), 1e-6f, "grey");
  expect_color(color_at(grey, {14, 4, 4}), Rgb(1.0f), 0, "clamped");
  EXPECT_EQ(color_at(grey, {99, 4, 4}), Rgb(0.0f)) << "numbers are 0 outside";
  map.map.power = 1;
  assign(map.colors,
         Value::List{Value::List{0.25, 1.0, 0.5, 0.0}, Value::List{0.75, 0.0, 0.5, 1.0}});
  const AlbedoField ramp = make_albedo_field(map, {f.grid, pyramid}, {});
  expect_color(color_at(ramp, {5, 4, 4}), Rgb(0.5f, 0.5f, 0.5f), 1e-6f, "between points");
  expect_color(color_at(ramp, {3.5, 4, 4}), Rgb(0.8f, 0.5f, 0.2f), 1e-6f, "between points");
  EXPECT_EQ(color_at(ramp, {99, 4, 4}), Rgb(1.0f, 0.5f, 0.0f)) << "that of 0 outside";
}

float largest_of(std::shared_ptr<const AlbedoField> field, Rgb albedo) {
  Volume v;
  v.medium.components.front().albedo = albedo;
  v.albedo = std::move(field);
  return largest_albedo(v);
}

TEST(AlbedoField, BoundsTheAlbedo) {
  const Field& density = cloud();
  const auto dim = [](Vec3i p) { return Rgb(0.5f, p.x == 0 ? 0.25f : 0.125f, 0.0f); };
  const ColorGrid all = make_colors({-12, -12, -12}, {24, 24, 24}, dim);
  EXPECT_EQ(largest_of(nullptr, Rgb(0.9f, 0.5f, 1.0f)), 1.0f);
  EXPECT_EQ(largest_of(albedo_of(all, &density.grid), Rgb(0.5f, 1.0f, 1.0f)), 0.25f);
  EXPECT_EQ(largest_of(albedo_of(all), Rgb(0.5f, 0.75f, 0.5f)), 0.75f) << "not known to be covered";
  const ColorGrid part = make_colors({-12, -12, -12}, {23, 24, 24}, [&](Vec3i p) {
    return p == Vec3i(0, 0, 0) ? std::nullopt : std::optional(dim(p));
  });
  EXPECT_EQ(largest_of(albedo_of(part, &density.grid), Rgb(0.75f)), 0.75f) << "a sample says none";
  const Field tile = make_field(
      "tile", {0, 0, 0}, {128, 128, 128}, [](Vec3i) { return 1.0; }, Tiles::edge_128);
  ASSERT_FALSE(tile.grid.tiles.empty());
  EXPECT_EQ(largest_of(albedo_of(all, &tile.grid), Rgb(0.75f)), 0.75f) << "a tile beyond";
}

TEST(AlbedoField, BoundsWhatNumbersStandFor) {
  AlbedoMap map{.map = {.scale = 0.5}};
  EXPECT_EQ(largest_color(map, 1), Rgb(0.5f));
  EXPECT_EQ(largest_color(map, 100), Rgb(1.0f)) << "clamped";
  map.map = {.scale = -1, .offset = 0.75};
  EXPECT_EQ(largest_color(map, 1), Rgb(0.75f)) << "that of 0";
  assign(map.colors, Value::List{Value::List{0.0, 0.2, 0.0, 1.0}, Value::List{1.0, 0.4, 0.0, 0.5}});
  expect_color(largest_color(map, 1), Rgb(0.35f, 0.0f, 1.0f), 1e-5f, "by the ramp");
}

TEST(AlbedoField, RefusesWhatCannotBe) {
  const ColorGrid colors = make_colors({0, 0, 0}, {8, 8, 8}, [](Vec3i) { return Rgb(0.5f); });
  const auto refusal = [&](const AlbedoMap& map) {
    return error_of([&] { (void)make_albedo_field(map, colors, nullptr, {}); });
  };
  EXPECT_TRUE(says(refusal({.map = {.scale = 2}}), "albedo.colours_are_not_mapped"));
  const Field f = make_field("heat", {0, 0, 0}, {8, 8, 8}, [](Vec3i) { return 1.0; });
  const Pyramid pyramid = build_pyramid(f.grid);
  AlbedoMap map;
  assign(map.colors, Value::List{0.0, 0.5, 1.5, 0.5});
  EXPECT_TRUE(says(error_of([&] {
                     (void)make_albedo_field(map, {f.grid, pyramid}, {});
                   }),
                   "albedo.colors_expected_colours"));
  ColorGrid far = colors;
  for (VoxelGrid* g : {&far.channels[0], &far.known}) {
    g->tiles.push_back({{1 << 20, 1 << 20, 1 << 20}, 8, 1});
  }
  EXPECT_TRUE(
      says(error_of([&] { (void)make_albedo_field({}, far, nullptr, {}); }), "albedo.box_grid_cd"));
}

TEST(ColorGrid, KnowsItsBlackSamplesAgain) {
  const ColorGrid colors = make_colors({-5, 0, 0}, {20, 9, 9}, [](Vec3i p) {
    if (p.x > 9) return std::optional<Rgb>();
    return std::optional(p.x < 0 ? Rgb(0.0f) : Rgb(0.0f, float(p.y) / 16, 0.0f));
  });
  const VoxelGrid black = black_of(colors);
  const VoxelGrid known = known_of(colors.channels, &black);
  const VoxelGrid less = known_of(colors.channels, nullptr);
  for (int x = -6; x < 16; ++x) {
    for (int y = -1; y < 10; ++y) {
      EXPECT_EQ(sample(known, {x, y, 3}), sample(colors.known, {x, y, 3})) << x << ' ' << y;
      const bool bright = x >= 0 && x <= 9 && y > 0 && y < 9;
      EXPECT_EQ(sample(less, {x, y, 3}), bright ? 1 : 0) << x << ' ' << y;
    }
  }
  const ColorGrid grey = make_colors({0, 0, 0}, {8, 8, 8}, [](Vec3i) { return Rgb(0.5f); });
  EXPECT_TRUE(black_of(grey).bricks.empty());
}

TEST(ColorGrid, KnowsItsBlackTilesAgain) {
  ColorGrid colors = make_colors({0, 0, 0}, {8, 8, 8}, [](Vec3i) { return Rgb(0.5f); });
  colors.known.tiles.push_back({{16, 0, 0}, 8, 1});
  const VoxelGrid black = black_of(colors);
  EXPECT_EQ(sample(black, {17, 1, 1}), 1);
  EXPECT_EQ(sample(black, {1, 1, 1}), 0);
}

TEST(ColorGrid, KnowsTheColoursOfTilesAgain) {
  std::array<VoxelGrid, 3> channels;
  channels[0].tiles.push_back({{128, 0, 0}, 128, 0.5f});
  channels[2].tiles.push_back({{128, 0, 0}, 128, 0.25f});
  channels[2].tiles.push_back({{0, 8, 0}, 8, 0.25f});
  const VoxelGrid known = known_of(channels, nullptr);
  EXPECT_EQ(known.tiles.size(), 2u);
  for (const Vec3i p : {Vec3i(128, 0, 0), Vec3i(255, 127, 127), Vec3i(0, 8, 0)}) {
    EXPECT_EQ(sample(known, p), 1) << p.x;
  }
  EXPECT_EQ(sample(known, {127, 0, 0}), 0);
}

}  // namespace albedo_field_test
}  // namespace pvol::test
