// Which grid is taken for what, by the names that programs write.
#include "pvol/formats/field_names.h"

#include <gtest/gtest.h>

#include "support/error_of.h"

namespace pvol::formats {
namespace {

using test::error_of;

std::vector<GridEntry> grids(std::initializer_list<const char*> names) {
  std::vector<GridEntry> all;
  for (const char* name : names) all.push_back({name, "float", true});
  return all;
}

TEST(FieldNames, FiresGoByFlamesAndTemperature) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(usual_fire_grids(grids({"density", "flames", "temperature"})),
            (Names{"flames", "temperature"}));
  EXPECT_EQ(usual_fire_grids(grids({"density", "Flame", "Temperature", "v"})),
            (Names{"Flame", "Temperature"}));
  EXPECT_EQ(usual_fire_grids(grids({"heat", "density"})), (Names{"heat"}));
  EXPECT_EQ(usual_fire_grids(grids({"temperature"})), (Names{"temperature"}));
  EXPECT_EQ(usual_fire_grids(grids({"density", "color"})), Names{});
  auto vectors = grids({"flames", "temperature"});
  vectors[0].usable = false;  // a vector grid of that name is none
  EXPECT_EQ(usual_fire_grids(vectors), (Names{"temperature"}));
}

TEST(FieldNames, AFileLacksDensityWhereNoGridIsPlainlyIt) {
  EXPECT_TRUE(lacks_density(grids({"flames", "temperature"})));
  EXPECT_FALSE(lacks_density(grids({"density", "flames"})));
  EXPECT_FALSE(lacks_density(grids({"DENSITY", "flames"})));
  EXPECT_FALSE(lacks_density(grids({"flames"}))) << "the only grid is the density";
  auto empty = grids({"density", "flames"});
  empty[0].usable = false;
  EXPECT_TRUE(lacks_density(empty));
}

TEST(FieldNames, AFileWithoutDensityBecomesAFire) {
  SceneVolume v{.file = "fire.vdb"};
  const auto notes = bind_fields(v, grids({"flames", "temperature"}));
  EXPECT_EQ(v.grid, kNoGrid);
  ASSERT_TRUE(v.fire);
  EXPECT_EQ(v.fire->field, "flames");
  EXPECT_EQ(v.fire->color_by, "temperature");
  EXPECT_TRUE(v.fire->kelvin);
  EXPECT_EQ(notes.size(), 3u);
}

TEST(FieldNames, WhatTheSceneSaysStays) {
  SceneVolume smoke{.file = "fire.vdb"};
  EXPECT_TRUE(bind_fields(smoke, grids({"density", "flames"})).empty());
  EXPECT_FALSE(smoke.fire) << "smoke is no fire unless it is said";
  SceneVolume named{.file = "fire.vdb", .grid = "temperature"};
  EXPECT_TRUE(bind_fields(named, grids({"flames", "temperature"})).empty());
  EXPECT_EQ(named.grid, "temperature");
  SceneVolume both{.file = "fire.vdb", .fire = Fire{.field = "heat", .color_by = "flames"}};
  both.fire->kelvin = 1500;
  EXPECT_TRUE(bind_fields(both, grids({"density", "flames", "heat", "temperature"})).empty());
  EXPECT_EQ(both.fire->field, "heat");
  EXPECT_EQ(both.fire->color_by, "flames");
  SceneVolume grey{.file = "fire.vdb", .fire = Fire{}};
  EXPECT_EQ(bind_fields(grey, grids({"density", "flames", "temperature"})).size(), 1u);
  EXPECT_EQ(grey.fire->color_by, "") << "nothing asks for a colour";
}

TEST(FieldNames, AFireWithNothingToGoByIsRefused) {
  SceneVolume v{.file = "fire.vdb", .fire = Fire{}};
  EXPECT_EQ(error_of([&] {
              (void)bind_fields(v, grids({"density", "v"}));
            }),
            "fire.vdb: no grid is called flames, heat, temperature or the like, which a fire could "
            "go by; name one with medium.fire.field; the file has: density (float), v (float)");
}

}  // namespace
}  // namespace pvol::formats
