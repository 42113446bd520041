// Which grid is taken for what, by the names that programs write.
#include "pvol/formats/field_names.h"

#include <gtest/gtest.h>

#include "pvol/formats/color.h"
#include "pvol/formats/velocity.h"
#include "support/error_of.h"
#include "support/messages.h"

namespace pvol::formats {
namespace field_names_test {

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

TEST(FieldNames, ADensityOfAnotherTypeIsNamed) {
  std::vector<GridEntry> all = grids({"temperature", "flames"});
  all.push_back({"density", "int32", false});
  SceneVolume v;
  EXPECT_TRUE(says(bind_fields(v, all).front(), "grids.density_of_another_type"));
  EXPECT_EQ(v.grid, kNoGrid);
}

TEST(FieldNames, VelocitiesAreVectorsOrThreeNumbers) {
  for (const char* between : {".", "_", ""}) {
    std::vector<std::string> names = {"density"};
    for (const char* axis : {"x", "y", "z"}) names.push_back(std::string("Vel") + between + axis);
    auto all = grids({names[0].c_str(), names[1].c_str(), names[2].c_str(), names[3].c_str()});
    EXPECT_TRUE(has_velocity(all, "vel")) << names[1];
    EXPECT_FALSE(has_velocity(all, "v")) << names[1];
    EXPECT_EQ(usual_velocity(all), "vel") << names[1];
    for (std::size_t axis = 1; axis < 4; ++axis) {
      auto changed = all;
      changed[axis].type = "vec3s";
      EXPECT_FALSE(has_velocity(changed, "vel")) << "a vector grid is no number: " << names[axis];
      changed.erase(changed.begin() + std::ptrdiff_t(axis));
      EXPECT_FALSE(has_velocity(changed, "vel")) << "without " << names[axis];
    }
  }
  EXPECT_FALSE(has_velocity(grids({"vel"}), "vel")) << "numbers are no velocities";
  EXPECT_EQ(usual_velocity(grids({"density", "temperature"})), "");
}

/// Numbers called density, and vectors of these names.
std::vector<GridEntry> colors(std::initializer_list<const char*> names) {
  std::vector<GridEntry> all = grids({"density"});
  for (const char* name : names) all.push_back({name, "vec3s", false});
  return all;
}

TEST(FieldNames, ColoursAreVectorsOrThreeNumbers) {
  EXPECT_EQ(usual_color_grid(colors({"v", "albedo", "cd"})), "cd") << "Cd comes first";
  EXPECT_EQ(usual_color_grid(colors({"Color"})), "Color");
  EXPECT_EQ(usual_color_grid(colors({"v"})), "");
  EXPECT_EQ(usual_color_grid(grids({"density", "Cd"})), "") << "numbers are no colours";
  EXPECT_EQ(usual_color_grid(grids({"density", "Cd.x", "Cd.y", "Cd.z"})), "Cd");
  EXPECT_EQ(usual_color_grid(grids({"density", "Cd.x", "Cd.y"})), "");
  EXPECT_TRUE(has_colors(colors({"tint"}), "tint"));
  EXPECT_FALSE(has_colors(colors({"tint"}), "density"));
}

TEST(FieldNames, AlbedosGoByColoursUnlessTheSceneSaysSo) {
  SceneVolume v{.file = "smoke.vdb"};
  const std::vector<std::string> used = bind_albedo(v, colors({"Cd"}));
  ASSERT_EQ(used.size(), 1u);
  EXPECT_TRUE(says(used[0], "grids.albedo_uses_colours"));
  ASSERT_TRUE(v.albedo_field);
  EXPECT_EQ(v.albedo_field->grid, "Cd");
  EXPECT_TRUE(bind_albedo(v, colors({"color"})).empty()) << "it has one";
  SceneVolume none{.file = "smoke.vdb", .albedo_field = AlbedoMap{.grid = kNoGrid}};
  EXPECT_TRUE(bind_albedo(none, colors({"Cd"})).empty());
  EXPECT_EQ(none.albedo_field->grid, kNoGrid);
  SceneVolume fire{.file = "smoke.vdb", .grid = kNoGrid};
  EXPECT_TRUE(bind_albedo(fire, colors({"Cd"})).empty());
  EXPECT_FALSE(fire.albedo_field) << "a fire alone has no albedo";
  SceneVolume plain{.file = "smoke.vdb"};
  EXPECT_TRUE(bind_albedo(plain, colors({"v"})).empty());
  EXPECT_FALSE(plain.albedo_field);
  SceneVolume nano{.file = "smoke.nvdb"};
  const std::vector<std::string> ignored = bind_albedo(nano, colors({"Cd"}));
  ASSERT_EQ(ignored.size(), 1u);
  EXPECT_TRUE(says(ignored[0], "grids.colours_grid_cd"));
  EXPECT_FALSE(nano.albedo_field);
  SceneVolume wanted{.file = "smoke.vdb", .albedo_field = AlbedoMap{}};
  EXPECT_TRUE(
      says(error_of([&] { (void)bind_albedo(wanted, colors({"v"})); }), "grids.no_grid_colours"));
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

TEST(FieldNames, AVolumeOfNoGridIsAFire) {
  SceneVolume v{.file = "fire.vdb", .grid = kNoGrid};
  EXPECT_EQ(bind_fields(v, grids({"density", "flames"})).size(), 2u);
  ASSERT_TRUE(v.fire);
  EXPECT_EQ(v.fire->field, "flames");
  EXPECT_TRUE(v.fire->kelvin);
  SceneVolume smoke{.file = "fire.vdb", .grid = kNoGrid};
  try {
    (void)bind_fields(smoke, grids({"density", "v"}));
    FAIL();
  } catch (const Error& e) {
    EXPECT_TRUE(says(e.what(), "grids.no_grid_called_flames")) << e.what();
  }
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

TEST(FieldNames, FlamesAreShownBesideADensityWhereFiresAre) {
  SceneVolume v{.file = "fire.vdb", .shows_fire = true};
  EXPECT_EQ(bind_fields(v, grids({"density", "flames", "temperature"})).size(), 3u);
  EXPECT_EQ(v.grid, "") << "the density is there as well";
  ASSERT_TRUE(v.fire);
  EXPECT_EQ(v.fire->field, "flames");
  EXPECT_TRUE(v.fire->kelvin);
  SceneVolume dim{.file = "fire.vdb", .fire = Fire{.intensity = 0.1}, .shows_fire = true};
  EXPECT_EQ(bind_fields(dim, grids({"density", "flames"})).size(), 2u);
  EXPECT_TRUE(dim.fire->kelvin) << "what is said of its brightness leaves the colour";
  SceneVolume named{.file = "fire.vdb", .grid = "density", .shows_fire = true};
  EXPECT_TRUE(bind_fields(named, grids({"density", "flames"})).empty());
  SceneVolume warm{.file = "smoke.vdb", .shows_fire = true};
  EXPECT_TRUE(bind_fields(warm, grids({"density", "temperature"})).empty());
  EXPECT_FALSE(warm.fire) << "temperatures drive smoke as well";
}

TEST(FieldNames, AFireWithNothingToGoByIsRefused) {
  SceneVolume v{.file = "fire.vdb", .fire = Fire{}};
  EXPECT_TRUE(says(error_of([&] {
                     (void)bind_fields(v, grids({"density", "v"}));
                   }),
                   "grids.no_grid_called_flames"));
}

}  // namespace field_names_test
}  // namespace pvol::formats
