#include "pvol/formats/recipe_file.h"

#include <cmath>
#include <numbers>

#include "pvol/error.h"
#include "pvol/medium/cumulus.h"
#include "toml_table.h"

namespace pvol::formats {
namespace {

constexpr int kResolution = 256;
constexpr double kHeight = 0.55;  // of a cumulus in widths, as in struct Cumulus
constexpr std::int64_t kLargestSeed = std::numeric_limits<std::int64_t>::max();

/// Rotation about x, then y, then z, angles in degrees.
Affine rotation(Vec3d degrees) {
  Affine result;
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = degrees[axis] * std::numbers::pi / 180;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    Affine turn;
    turn.m[std::size_t(u)][u] = turn.m[std::size_t(v)][v] = std::cos(angle);
    turn.m[std::size_t(v)][u] = std::sin(angle);
    turn.m[std::size_t(u)][v] = -std::sin(angle);
    result = turn * result;
  }
  return result;
}

/// A quadric, and the factor that makes its values about distances from the surface.
struct Shape {
  Quadric quadric;
  double to_distance = 1;
};

Shape read_ellipsoid(const TomlTable& table) {
  table.require({"centre", "radii"});
  const Vec3d radii = *table.number_or_vector("radii", Range::closed(1e-30, 1e30));
  const Vec3d degrees = table.vector("rotation").value_or(Vec3d{});
  const Affine turn = degrees == Vec3d{} ? Affine{} : rotation(degrees);
  // 1 - |p/r|^2 falls by 2/r for each unit of distance, fastest along the shortest axis.
  return {ellipsoid(*table.vector("centre"), radii, turn), 0.5 * min_component(radii)};
}

Shape read_coefficients(const TomlTable& table) {
  table.require({"coefficients"});
  const std::vector<double> c = *table.numbers("coefficients", {10});
  return {{{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}, c[9]}};
}

Shape read_half_space(const TomlTable& table) {
  table.require({"point", "inward"});
  return {half_space(*table.vector("point"), *table.direction("inward"))};
}

/// The quadric of a table that may also have the key `a` and, if it is not empty, `b`.
Shape read_shape(const TomlTable& table, std::string_view a, std::string_view b = "") {
  const auto allow = [&](auto... keys) {
    b.empty() ? table.allow_only({"shape", keys..., a})
              : table.allow_only({"shape", keys..., a, b});
  };
  table.require({"shape"});
  const std::string shape = *table.word("shape", {"ellipsoid", "half-space", "quadric"});
  if (shape == "ellipsoid") {
    allow("centre", "radii", "rotation");
    return read_ellipsoid(table);
  }
  if (shape == "half-space") {
    allow("point", "inward");
    return read_half_space(table);
  }
  allow("coefficients");
  return read_coefficients(table);
}

double read_steepness(const TomlTable& table) {
  return table.number("steepness", Range::above(0)).value_or(1);
}

FreeForm read_form(const TomlTable& table) {
  const Shape shape = read_shape(table, "steepness", "perturbation");
  FreeForm form{shape.to_distance * shape.quadric, {}};
  for (const TomlTable* p : table.tables("perturbation")) {
    p->require({"strength"});
    form.perturbations.push_back({read_shape(*p, "strength").quadric, *p->number("strength")});
  }
  return read_steepness(table) * form;
}

Displacement read_displacement(const TomlTable& table) {
  table.allow_only({"kind", "amplitude", "cell", "octaves", "gain", "seed", "mask"});
  table.require({"amplitude", "cell"});
  Displacement d;
  d.amplitude = *table.number("amplitude");
  d.noise.billow = table.word("kind", {"smooth", "billow"}).value_or("smooth") == "billow";
  d.noise.cell = *table.number("cell", Range::closed(1e-30, 1e30));
  d.noise.octaves = int(table.integer("octaves", 1, kMaxOctaves).value_or(d.noise.octaves));
  d.noise.gain = table.number("gain", Range{0, 1, true, false}).value_or(d.noise.gain);
  d.noise.seed = std::uint64_t(table.integer("seed", 0, kLargestSeed).value_or(1));
  if (const TomlTable* mask = table.table("mask")) {
    const Shape shape = read_shape(*mask, "steepness");
    d.mask = read_steepness(*mask) * shape.to_distance * shape.quadric;
  }
  return d;
}

Recipe read_cumulus(const TomlTable& table) {
  table.allow_only({"seed", "width", "height", "towers", "generations", "detail", "wisps"});
  Cumulus c;
  c.seed = std::uint64_t(table.integer("seed", 0, kLargestSeed).value_or(1));
  c.width = table.number("width", Range::closed(1e-20, 1e20)).value_or(c.width);
  c.height = table.number("height", Range::above(0)).value_or(kHeight * c.width);
  c.towers = int(table.integer("towers", 1, kMostTowers).value_or(c.towers));
  c.generations = int(table.integer("generations", 0, 3).value_or(c.generations));
  c.detail = table.number("detail", Range::closed(0, 2)).value_or(c.detail);
  c.wisps = table.number("wisps", Range::closed(0, 2)).value_or(c.wisps);
  try {
    return make_recipe(c);
  } catch (const Error& e) {
    throw Error(table.where + ": " + e.what());
  }
}

void read_sampling(const TomlTable& table, Recipe& recipe) {
  table.allow_only({"name", "resolution", "voxel", "density", "edge"});
  recipe.name = table.string("name").value_or(recipe.name);
  if (recipe.name.empty()) table.fail("name", "a name of at least one character");
  recipe.density = table.number("density", Range::closed(1e-30, 1e30)).value_or(recipe.density);
  recipe.edge = table.number("edge", Range::closed(1e-30, 1e30)).value_or(recipe.edge);
  if (table.has("voxel") && table.has("resolution")) {
    table.fail("voxel", "either voxel or resolution, not both");
  }
  const auto resolution = table.integer("resolution", 1, kLargestResolution);
  recipe.voxel = voxel_for(recipe, int(resolution.value_or(kResolution)));
  recipe.voxel = table.number("voxel", Range::closed(1e-30, 1e30)).value_or(recipe.voxel);
}

Recipe read(const TomlTable& root) {
  root.allow_only({"recipe", "cumulus", "form", "cut", "displacement"});
  root.require({"recipe"});
  const TomlTable* cumulus = root.table("cumulus");
  Recipe recipe = cumulus ? read_cumulus(*cumulus) : Recipe{};
  for (const TomlTable* t : root.tables("form")) recipe.forms.push_back(read_form(*t));
  for (const TomlTable* t : root.tables("cut")) recipe.cuts.push_back(read_form(*t));
  for (const TomlTable* t : root.tables("displacement")) {
    recipe.displacements.push_back(read_displacement(*t));
  }
  if (recipe.forms.empty()) {
    throw Error(root.where + ": there is no cloud; add [cumulus] or a [[form]]");
  }
  const TomlTable& table = *root.table("recipe");
  read_sampling(table, recipe);
  try {
    validate(recipe);
  } catch (const Error& e) {
    throw Error(table.where + ": " + e.what());
  }
  return recipe;
}

}  // namespace

Recipe read_recipe(const std::filesystem::path& file) { return read(parse_toml_file(file)); }

Recipe parse_recipe(std::string_view text, const std::string& source) {
  return read(parse_toml(text, source));
}

bool is_recipe(const std::filesystem::path& file) { return parse_toml_file(file).has("recipe"); }

}  // namespace pvol::formats
