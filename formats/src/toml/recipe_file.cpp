#include "pvol/formats/recipe_file.h"

#include <iterator>
#include <numbers>
#include <utility>

#include "pvol/density/cumulus.h"
#include "pvol/error.h"
#include "toml/recipe_body.h"
#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

constexpr int kResolution = 256;
constexpr double kHeight = 0.55;  // of a cumulus in widths, as in struct Cumulus
constexpr std::int64_t kLargestSeed = std::numeric_limits<std::int64_t>::max();

/// All of a noise but its kind.
Fbm read_fbm(const TomlTable& table) {
  Fbm noise;
  noise.cell = table.number("cell", Range::closed(1e-30, 1e30)).value_or(noise.cell);
  noise.octaves = int(table.integer("octaves", 1, kMaxOctaves).value_or(noise.octaves));
  noise.gain = table.number("gain", Range{0, 1, true, false}).value_or(noise.gain);
  noise.seed = std::uint64_t(table.integer("seed", 0, kLargestSeed).value_or(1));
  return noise;
}

MaskedNoise read_noise(const TomlTable& table) {
  table.allow_only({"kind", "amplitude", "cell", "octaves", "gain", "seed", "mask"});
  table.require({"amplitude", "cell"});
  MaskedNoise n;
  n.amplitude = *table.number("amplitude");
  n.noise = read_fbm(table);
  n.noise.billow = table.word("kind", {"smooth", "billow"}).value_or("smooth") == "billow";
  if (const TomlTable* mask = table.table("mask")) n.mask = read_mask(*mask);
  return n;
}

void read_noises(const TomlTable& root, std::string_view key, std::vector<MaskedNoise>& noises) {
  for (const TomlTable* table : root.tables(key)) noises.push_back(read_noise(*table));
}

/// A word, or a table of (depth, density).
Profile read_profile(const TomlTable& table) {
  const TomlValue* value = table.find("profile");
  if (value == nullptr) return {};
  if (std::holds_alternative<std::string>(value->value)) {
    const std::string word = *table.word("profile", {"linear", "smooth"});
    return {word == "linear" ? ProfileKind::linear : ProfileKind::smooth, {}};
  }
  if (!std::holds_alternative<TomlArray>(value->value)) {
    table.fail("profile", "\"linear\", \"smooth\" or an array of [depth, density]");
  }
  Profile profile{ProfileKind::table, {}};
  const auto rows = *table.rows("profile", 2);
  for (const std::vector<double>& row : rows) {
    profile.points.push_back({row[0], row[1]});
  }
  return profile;
}

void append(std::vector<Body>& bodies, std::vector<Body> more) {
  std::move(more.begin(), more.end(), std::back_inserter(bodies));
}

Solid read_solid(const TomlTable& table, BodyReader& reader) {
  table.allow_only({"density", "edge", "form", "cut"});
  Solid solid;
  solid.density = table.number("density", Range::closed(1e-30, 1e30)).value_or(solid.density);
  solid.edge = table.number("edge", Range::closed(1e-30, 1e30)).value_or(solid.edge);
  std::vector<Body> forms = reader.read_all(table, "form");
  if (forms.empty()) table.fail("form", "at least one form, [[solid.form]]");
  solid.body = {BodyOp::join, std::move(forms)};
  std::vector<Body> all = reader.read_all(table, "cut");
  if (all.empty()) return solid;
  all.push_back(std::move(solid.body));
  solid.body = {BodyOp::intersection, std::move(all)};
  return solid;
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
  table.allow_only({"name", "resolution", "voxel", "density", "edge", "profile"});
  recipe.name = table.string("name").value_or(recipe.name);
  if (recipe.name.empty()) table.fail("name", "a name of at least one character");
  recipe.density = table.number("density", Range::closed(1e-30, 1e30)).value_or(recipe.density);
  recipe.edge = table.number("edge", Range::closed(1e-30, 1e30)).value_or(recipe.edge);
  recipe.profile = read_profile(table);
  if (table.has("voxel") && table.has("resolution")) {
    table.fail("voxel", "either voxel or resolution, not both");
  }
  const auto resolution = table.integer("resolution", 1, kLargestResolution);
  recipe.voxel = voxel_for(recipe, int(resolution.value_or(kResolution)));
  recipe.voxel = table.number("voxel", Range::closed(1e-30, 1e30)).value_or(recipe.voxel);
}

Flow read_flow_table(const TomlTable& table) {
  table.allow_only(
      {"velocity", "spin", "stretch", "centre", "turbulence", "cell", "octaves", "gain", "seed"});
  constexpr double kDegree = std::numbers::pi / 180;
  Flow f;
  f.velocity = table.vector("velocity").value_or(f.velocity);
  f.spin = table.vector("spin").value_or(f.spin) * kDegree;
  f.stretch = table.vector("stretch").value_or(f.stretch);
  f.centre = table.vector("centre").value_or(f.centre);
  f.turbulence = table.number("turbulence", Range::at_least(0)).value_or(f.turbulence);
  f.noise = read_fbm(table);
  if (f.turbulence > 0) table.require({"cell"});
  try {
    validate(f);
  } catch (const Error& e) {
    throw Error(table.where + ": " + e.what());
  }
  return f;
}

std::optional<Flow> read_flow(const TomlTable& root) {
  const TomlTable* table = root.table("flow");
  if (table == nullptr) return std::nullopt;
  return read_flow_table(*table);
}

Recipe read(const TomlTable& root) {
  root.allow_only(
      {"recipe", "cumulus", "body", "form", "cut", "displacement", "modulation", "solid", "flow"});
  root.require({"recipe"});
  const TomlTable* cumulus = root.table("cumulus");
  Recipe recipe = cumulus ? read_cumulus(*cumulus) : Recipe{};
  BodyReader reader(root);
  append(recipe.forms, reader.read_all(root, "form"));
  append(recipe.cuts, reader.read_all(root, "cut"));
  read_noises(root, "displacement", recipe.displacements);
  read_noises(root, "modulation", recipe.modulations);
  for (const TomlTable* t : root.tables("solid")) recipe.solids.push_back(read_solid(*t, reader));
  if (recipe.forms.empty() && recipe.solids.empty()) {
    throw Error(root.where + ": there is no cloud; add [cumulus], a [[form]] or a [[solid]]");
  }
  (void)read_flow(root);  // refused with the rest
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

std::optional<Flow> read_flow(const std::filesystem::path& file) {
  return read_flow(parse_toml_file(file));
}

std::optional<Flow> parse_flow(std::string_view text, const std::string& source) {
  return read_flow(parse_toml(text, source));
}

bool is_recipe(const std::filesystem::path& file) { return parse_toml_file(file).has("recipe"); }

}  // namespace pvol::formats
