#include "pvol/formats/recipe_file.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pvol/density/cumulus.h"
#include "pvol/error.h"
#include "support/messages.h"

namespace pvol::formats {
namespace recipe_file_test {

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
  FreeForm first{1.0 * ellipsoid({1, 2, 3}, {4, 2, 4}), {{{ellipsoid({}, Vec3d(2)), {}}, -0.5}}};
  expected.forms = {3.0 * first, FreeForm{{{-1, -2, -3}, {4, 5, 6}, {7, 8, 9}, 10}, {}}};
  expected.cuts = {FreeForm{half_space({0, 1, 0}, {0, 1, 0}), {}},
                   FreeForm{4.5 * ellipsoid({}, Vec3d(9)), {}}};
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
  EXPECT_NEAR(value(r.forms[0].form.base, {4, 0, 0}), 0, 1e-12);
  EXPECT_NEAR(value(r.forms[0].form.base, {0, 0, 2}), 0, 1e-12);
  EXPECT_NEAR(value(r.forms[0].form.base, {0, 1, 0}), 0, 1e-12);
}

const std::string kHead = "[recipe]\nvoxel = 0.1\n";
const std::string kBall = "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";

TEST(RecipeFile, ReadsPerturbationsOfPerturbations) {
  const Recipe r = parse_recipe(kHead + "[[form]]\n" + kBall + "[[form.perturbation]]\n" + kBall +
                                    "strength = 2\n[[form.perturbation.perturbation]]\n" + kBall +
                                    "strength = -3\n",
                                "r.toml");
  const Quadric q = ellipsoid({}, Vec3d(1));
  EXPECT_EQ(r.forms[0].form, (FreeForm{0.5 * q, {{{q, {{{q, {}}, -3}}}, 2}}}));
}

TEST(RecipeFile, ScalesThenTurnsThenMoves) {
  const Recipe r = parse_recipe(
      kHead + "[[form]]\n" + kBall +
          "scale = [2, 0.5, 1]\nrotate = [0, 0, 90]\ntranslate = [10, 20, 30]\nsteepness = 3\n",
      "r.toml");
  // Half-axes 0.5 along x, 2 along y and 1 along z, around the new centre.
  EXPECT_NEAR(value(r.forms[0], {10.5, 20, 30}), 0, 1e-9);
  EXPECT_NEAR(value(r.forms[0], {10, 22, 30}), 0, 1e-9);
  EXPECT_NEAR(value(r.forms[0], {10, 20, 31}), 0, 1e-9);
  // As deep as half the shortest axis, times the steepness: an ellipsoid of those radii.
  EXPECT_NEAR(value(r.forms[0], {10, 20, 30}), 3 * 0.25, 1e-9);
}

TEST(RecipeFile, ReadsTreesAndNamedBodies) {
  const Recipe r = parse_recipe(kHead + R"(
[[body.pair]]
shape = "ellipsoid"
centre = [0, 0, 0]
radii = 1
[[body.pair]]
shape = "ellipsoid"
centre = [1, 0, 0]
radii = 1
[[body.holes]]
use = "pair"
scale = 0.5
[[form]]
op = "difference"
part = [{ use = "pair" }, { use = "holes" }]
[[cut]]
op = "union"
[[cut.part]]
shape = "half-space"
point = [0, 0, 0]
inward = [0, 1, 0]
[[cut.part]]
op = "intersection"
part = { use = "pair", translate = [0, 1, 0] }
)",
                                "r.toml");
  const FreeForm left{0.5 * ellipsoid({}, Vec3d(1)), {}},
      right{0.5 * ellipsoid({1, 0, 0}, Vec3d(1)), {}};
  const Body pair{BodyOp::join, {left, right}};
  const Body holes = 0.5 * transform(scaling(Vec3d(0.5)), pair);
  EXPECT_EQ(r.forms, (std::vector<Body>{{BodyOp::difference, {pair, holes}}}));
  const FreeForm above{half_space({}, {0, 1, 0}), {}};
  const Body moved{BodyOp::intersection, {transform(translation({0, 1, 0}), pair)}};
  EXPECT_EQ(r.cuts, (std::vector<Body>{{BodyOp::join, {above, moved}}}));
}

TEST(RecipeFile, ReadsProfilesModulationsAndSolids) {
  const std::string rest = "[[form]]\n" + kBall +
                           "[[modulation]]\namplitude = 0.5\ncell = 2\nseed = 9\n"
                           "[[solid]]\ndensity = 7\nedge = 0.5\n[[solid.form]]\n" +
                           kBall + "[[solid.cut]]\n" + kBall;
  const Recipe r = parse_recipe(kHead + "profile = [[0, 0], [1, 2], [2.5, 1]]\n" + rest, "r.toml");
  const FreeForm ball{0.5 * ellipsoid({}, Vec3d(1)), {}};
  EXPECT_EQ(r.profile, (Profile{ProfileKind::table, {{0, 0}, {1, 2}, {2.5, 1}}}));
  EXPECT_EQ(r.modulations, (std::vector<MaskedNoise>{{{.seed = 9, .cell = 2}, 0.5}}));
  const Body body{BodyOp::intersection, {ball, Body{BodyOp::join, {ball}}}};
  EXPECT_EQ(r.solids, (std::vector<Solid>{{body, 7, 0.5}}));
  EXPECT_EQ(parse_recipe(kHead + "profile = \"smooth\"\n" + rest, "r.toml").profile.kind,
            ProfileKind::smooth);
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
  for (const char* name :
       {"cumulus.toml", "stratus.toml", "column.toml", "chapel.toml", "solid.toml"}) {
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

/// Bodies b1, b2 ... each of which is twice the one before it, or the next one and nothing else.
std::string doublings(int count, const std::string& first) {
  std::string text;
  for (int i = 1; i <= count; ++i) {
    const std::string use = "use = \"" + (i > 1 ? "b" + std::to_string(i - 1) : first) + "\"\n";
    const std::string name = "[[body.b" + std::to_string(i) + "]]\n";
    text += name + use + name + use;
  }
  return text;
}
std::string doubled(int count, int bumps = 0) {
  std::string text = "[[body.b0]]\n" + kBall;
  for (int i = 0; i < bumps; ++i) text += "[[body.b0.perturbation]]\nstrength = 1\n" + kBall;
  return text + doublings(count, "b0");
}
std::string chained(int count) {
  std::string text;
  for (int i = 10; i < 10 + count; ++i) {
    text += "[[body.b" + std::to_string(i) + "]]\nuse = \"b" + std::to_string(i + 1) + "\"\n";
  }
  return text + "[[body.b" + std::to_string(10 + count) + "]]\n" + kBall;
}

struct Refusal {
  std::string text, key;
};

std::vector<Refusal> refusals() {
  const std::string head = "[recipe]\n", form = "[[form]]\nshape = \"ellipsoid\"\n";
  const std::string ball = form + "centre = [0, 0, 0]\nradii = 1\n";
  return {
      {"", "recipe.no_recipe"},
      {head, "recipe.no_cloud"},
      {head + "voxel = 0\n" + ball, "recipe.voxel_zero"},
      {head + "voxel = 1e-9\n" + ball, "recipe.longest_side"},
      {head + "voxel = 1\nresolution = 2\n" + ball, "recipe.voxel_1"},
      {head + "resolution = 5000\n" + ball, "recipe.resolution"},
      {head + "resolution = 0\n" + ball, "recipe.resolution"},
      {head + "edge = nan\n" + ball, "recipe.edge_nan"},
      {head + "name = \"\"\n" + ball, "recipe.name"},
      {head + "colour = 1\n" + ball, "recipe.no_key_recipe_colour"},
      {head + "[[form]]\nshape = \"cube\"\n", "recipe.form_shape_cube"},
      {head + "[[form]]\ncentre = [0, 0, 0]\n", "recipe.form_no_shape"},
      {head + form + "radii = 1\n", "recipe.form_no_centre"},
      {head + form + "centre = [0, 0]\nradii = 1\n", "recipe.form_centre_array_numbers"},
      {head + form + "centre = [0, 0, 0]\nradii = [1, 0, 1]\n", "recipe.form_radii_2_0"},
      {head + ball + "point = [0, 0, 0]\n", "recipe.no_key_form_point"},
      {head + ball + "steepness = -1\n", "recipe.form_steepness_negative"},
      {head + "[[form]]\nshape = \"quadric\"\ncoefficients = [1, 2]\n",
       "recipe.form_coefficients_array_numbers"},
      {head + "[[form]]\nshape = \"half-space\"\npoint = [0, 0, 0]\ninward = [0, 0, 0]\n",
       "recipe.form_inward_direction_not"},
      {head + "[[form]]\nshape = \"half-space\"\npoint = [0, 0, 0]\ninward = [0, 1, 0]\n",
       "recipe.forms_extend"},
      {head + ball +
           "[[form.perturbation]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n",
       "recipe.form_perturbation_no_strength"},
      {head + ball + "[[displacement]]\ncell = 1\n", "recipe.displacement_without_amplitude"},
      {head + ball + "[[displacement]]\namplitude = 1\ncell = 1\noctaves = 17\n",
       "recipe.displacement_octaves_17"},
      {head + ball + "[[displacement]]\namplitude = 1\ncell = 1\ngain = 0\n",
       "recipe.displacement_gain_zero"},
      {head + ball + "[[displacement]]\namplitude = 1\ncell = 1\nkind = \"bilow\"\n",
       "recipe.displacement_kind_bilow"},
      {head + "[[form]]\nuse = \"b\"\n", "recipe.form_use_b"},
      {head + "[[form]]\nuse = 1\n", "recipe.form_use_1"},
      {head + ball + "use = \"b\"\n", "recipe.form_expected_shape"},
      {head + ball + "op = \"union\"\n", "recipe.form_expected_shape"},
      {head + "[[form]]\nop = \"or\"\n", "recipe.form_op"},
      {head + "[[form]]\nop = \"union\"\n", "recipe.form_no_part"},
      {head + "[[form]]\nop = \"union\"\nradii = 1\n", "recipe.no_key_form_radii"},
      {head + "[[form]]\nop = \"union\"\n[[form.part]]\nradii = 1\n", "recipe.form_part_no_shape"},
      {head + "[[body.a]]\nuse = \"b\"\n[[body.b]]\nuse = \"a\"\n" + ball, "recipe.body_b_1_use"},
      {head + "[[body.a]]\nuse = \"a\"\n" + ball, "recipe.body_a_1_use"},
      {head + doubled(20) + "[[form]]\nuse = \"b20\"\n", "recipe.body_b16_1_use_b15"},
      {head + doubled(10, 100) + "[[form]]\nuse = \"b10\"\n", "recipe.body_b10_2_use_b9"},
      // An empty body costs nothing of that, whether it is read before its uses or by the first.
      {head + ball + "[body]\na = []\n" + doublings(40, "a"), "recipe.body_b1_use"},
      {head + ball + "[body]\nz = []\n" + doublings(40, "z"), "recipe.body_b1_use"},
      {head + chained(40) + "[[form]]\nuse = \"b10\"\n", "recipe.body_b41_1_use_b42"},
      {head + ball + "scale = 0\n", "recipe.form_scale_zero"},
      {head + ball + "scale = [1, 2]\n", "recipe.form_scale_of_two"},
      {head + ball + "rotate = 90\n", "recipe.form_rotate_90"},
      {head + ball + "translate = [nan, 0, 0]\n", "recipe.form_translate_1_nan"},
      {head + "profile = \"smoth\"\n" + ball, "recipe.profile_smoth"},
      {head + "profile = 1\n" + ball, "recipe.profile_1"},
      {head + "profile = [[0, 0], [1]]\n" + ball, "recipe.profile_2_array_numbers"},
      {head + "profile = [[0, 0]]\n" + ball, "recipe.number_points"},
      {head + "profile = [[0, 0], [0, 1]]\n" + ball, "recipe.profile_point"},
      {head + ball + "[[modulation]]\ncell = 1\n", "recipe.modulation_without_amplitude"},
      {head + ball + "[[solid]]\ndensity = 2\n", "recipe.solid_no_form"},
      {head + ball + "[[solid]]\ndensity = -1\n", "recipe.solid_density_negative"},
      {head + ball +
           "[[solid]]\n[[solid.form]]\nshape = \"half-space\"\npoint = [0, 0, 0]\n"
           "inward = [0, 1, 0]\n",
       "recipe.solid_extends"},
      {head + "[cumulus]\ntowers = 99\n", "recipe.cumulus_towers_99"},
      {head + "[cumulus]\nheight = 99\n", "recipe.cumulus_height"},
  };
}

TEST(RecipeFile, RefusesWithFileLineAndName) {
  for (const Refusal& c : refusals()) {
    EXPECT_TRUE(says(refusal(c.text), c.key)) << c.text;
  }
}

/// Bodies of 1 + 2 + ... + 512 forms, and uses of the largest and the smallest.
TEST(RecipeFile, TakesAsManyFormsAsItSaysAndNoMore) {
  constexpr const char* kLargest = "[[form]]\nuse = \"b9\"\n";
  constexpr const char* kSmallest = "[[form]]\nuse = \"b0\"\n";
  std::string text = "[recipe]\nvoxel = 1\n" + doubled(9);
  for (int n = 1023; n < 65535; n += 512) text += kLargest;
  EXPECT_EQ(refusal(text + kSmallest), "");
  EXPECT_TRUE(says(refusal(text + kSmallest + kSmallest), "recipe.form_128_use"));
}

}  // namespace recipe_file_test
}  // namespace pvol::formats
