#include "pvol/formats/recipe_file.h"

#include <gtest/gtest.h>

#include "pvol/error.h"
#include "pvol/medium/cumulus.h"

namespace pvol::formats {
namespace {

const std::filesystem::path kSamples = PVOL_SAMPLES;

TEST(RecipeFile, ReadsEveryKey) {
  const Recipe r = parse_recipe(R"(
[recipe]
name = "smoke"
voxel = 0.25
density = 2
edge = 0.5

[[form]]
shape = "ellipsoid"
centre = [1, 2, 3]
radii = [4, 2, 4]
steepness = 3
  [[form.perturbation]]
  shape = "ellipsoid"
  centre = [0, 0, 0]
  radii = 2
  strength = -0.5

[[form]]
shape = "quadric"
coefficients = [-1, -2, -3, 4, 5, 6, 7, 8, 9, 10]

[[cut]]
shape = "half-space"
point = [0, 1, 0]
inward = [0, 2, 0]

[[cut]]
shape = "ellipsoid"
centre = [0, 0, 0]
radii = 9

[[displacement]]
kind = "billow"
amplitude = -0.1
cell = 0.75
octaves = 3
gain = 0.25
seed = 77
mask = { shape = "half-space", point = [0, 0, 0], inward = [1, 0, 0], steepness = 4 }
)",
                                "r.toml");
  Recipe expected;
  expected.name = "smoke";
  expected.voxel = 0.25;
  expected.density = 2;
  expected.edge = 0.5;
  FreeForm first{1.0 * ellipsoid({1, 2, 3}, {4, 2, 4}), {{ellipsoid({}, Vec3d(2)), -0.5}}};
  expected.forms = {3.0 * first, {{{-1, -2, -3}, {4, 5, 6}, {7, 8, 9}, 10}, {}}};
  expected.cuts = {{half_space({0, 1, 0}, {0, 1, 0}), {}}, {4.5 * ellipsoid({}, Vec3d(9)), {}}};
  expected.displacements = {{{77, 0.75, 3, 0.25, true}, -0.1, 4.0 * half_space({}, {1, 0, 0})}};
  EXPECT_EQ(r, expected);
}

TEST(RecipeFile, RotationTurnsAboutXThenYThenZ) {
  const Recipe r = parse_recipe(R"(
recipe = {}
form = { shape = "ellipsoid", centre = [0, 0, 0], radii = [1, 2, 4], rotation = [90, 0, 90] }
)",
                                "r.toml");
  // The long axis z goes to -y, then to x; the middle one y to z, and stays; the short one x to y.
  EXPECT_NEAR(value(r.forms[0].base, {4, 0, 0}), 0, 1e-12);
  EXPECT_NEAR(value(r.forms[0].base, {0, 0, 2}), 0, 1e-12);
  EXPECT_NEAR(value(r.forms[0].base, {0, 1, 0}), 0, 1e-12);
}

TEST(RecipeFile, ReadsACumulusAndAddsToIt) {
  const std::string text =
      "[recipe]\nresolution = 100\n[cumulus]\nseed = 4\nwidth = 3\nheight = 1.5\ntowers = 2\n"
      "generations = 1\ndetail = 0.5\nwisps = 0.25\n";
  Recipe expected = make_recipe({.seed = 4,
                                 .width = 3,
                                 .height = 1.5,
                                 .towers = 2,
                                 .generations = 1,
                                 .detail = 0.5,
                                 .wisps = 0.25});
  expected.voxel = voxel_for(expected, 100);
  EXPECT_EQ(parse_recipe(text, "r.toml"), expected);
  const Recipe more = parse_recipe(
      text + "[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 1, 0]\nradii = 1\n", "r.toml");
  EXPECT_EQ(more.forms.size(), expected.forms.size() + 1);
}

TEST(RecipeFile, ResolutionCountsSamplesAlongTheLongestSide) {
  const Recipe r = parse_recipe(
      "[recipe]\nresolution = 50\nedge = 1e-9\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, "
      "0]\n"
      "radii = [1, 5, 2]\n",
      "r.toml");
  EXPECT_NEAR(r.voxel, 0.2, 1e-6);
}

TEST(RecipeFile, SamplesAreValidRecipes) {
  for (const char* name : {"cumulus.toml", "stratus.toml", "column.toml"}) {
    EXPECT_TRUE(is_recipe(kSamples / name));
    Recipe r = read_recipe(kSamples / name);
    r.voxel = voxel_for(r, 48);
    EXPECT_FALSE(make_grid(r).bricks.empty()) << name;
  }
}

/// The message about `text`, or "" where it is accepted.
std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_recipe(text, "r.toml"));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(RecipeFile, RefusesWithFileLineAndName) {
  const std::string head = "[recipe]\n", form = "[[form]]\nshape = \"ellipsoid\"\n";
  const std::string ball = form + "centre = [0, 0, 0]\nradii = 1\n";
  const struct {
    std::string text, place, word;
  } cases[] = {
      {"", "r.toml", "[recipe]"},
      {head, "r.toml", "[cumulus]"},
      {head + "voxel = 0\n" + ball, "r.toml:2:", "voxel"},
      {head + "voxel = 1e-9\n" + ball, "r.toml:1:", "longest side"},
      {head + "voxel = 1\nresolution = 2\n" + ball, "r.toml:2:", "not both"},
      {head + "resolution = 5000\n" + ball, "r.toml:2:", "resolution"},
      {head + "resolution = 0\n" + ball, "r.toml:2:", "resolution"},
      {head + "edge = nan\n" + ball, "r.toml:2:", "edge"},
      {head + "name = \"\"\n" + ball, "r.toml:2:", "name"},
      {head + "colour = 1\n" + ball, "r.toml:2:", "colour"},
      {head + "[[form]]\nshape = \"cube\"\n", "r.toml:3:", "cube"},
      {head + "[[form]]\ncentre = [0, 0, 0]\n", "r.toml:2:", "shape"},
      {head + form + "radii = 1\n", "r.toml:2:", "centre"},
      {head + form + "centre = [0, 0]\nradii = 1\n", "r.toml:4:", "centre"},
      {head + form + "centre = [0, 0, 0]\nradii = [1, 0, 1]\n", "r.toml:5:", "radii"},
      {head + ball + "point = [0, 0, 0]\n", "r.toml:6:", "point"},
      {head + ball + "steepness = -1\n", "r.toml:6:", "steepness"},
      {head + "[[form]]\nshape = \"quadric\"\ncoefficients = [1, 2]\n", "r.toml:4:", "10"},
      {head + "[[form]]\nshape = \"half-space\"\npoint = [0, 0, 0]\ninward = [0, 0, 0]\n",
       "r.toml:5:", "direction"},
      {head + "[[form]]\nshape = \"half-space\"\npoint = [0, 0, 0]\ninward = [0, 1, 0]\n",
       "r.toml:1:", "infinity"},
      {head + ball +
           "[[form.perturbation]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n",
       "r.toml:6:", "strength"},
      {head + ball + "[[displacement]]\ncell = 1\n", "r.toml:6:", "amplitude"},
      {head + ball + "[[displacement]]\namplitude = 1\ncell = 1\noctaves = 17\n",
       "r.toml:9:", "octaves"},
      {head + ball + "[[displacement]]\namplitude = 1\ncell = 1\ngain = 0\n", "r.toml:9:", "gain"},
      {head + ball + "[[displacement]]\namplitude = 1\ncell = 1\nkind = \"bilow\"\n",
       "r.toml:9:", "billow"},
      {head + "[cumulus]\ntowers = 99\n", "r.toml:3:", "towers"},
      {head + "[cumulus]\nheight = 99\n", "r.toml:2:", "height"},
  };
  for (const auto& c : cases) {
    const std::string message = refusal(c.text);
    EXPECT_EQ(message.rfind(c.place, 0), 0u) << c.text << "\n" << message;
    EXPECT_NE(message.find(c.word), std::string::npos) << c.text << "\n" << message;
  }
}

}  // namespace
}  // namespace pvol::formats
