#include "stats/fit_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cli/cli.h"
#include "pvol/density/sample_count.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/color.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/velocity.h"
#include "pvol/version.h"

namespace pvol::cli {

formats::Metadata describe_source(const FitOptions& o, const formats::LoadedGrid& loaded,
                                  LookUp look_up) {
  const formats::FileHash hash = formats::hash_file(o.input);
  formats::Metadata m;
  m.grid_name = loaded.grid.name;
  m.index_to_world = loaded.grid.index_to_world;
  const std::filesystem::path folder = std::filesystem::absolute(o.output).parent_path();
  m.source = {std::filesystem::proximate(std::filesystem::absolute(o.input), folder).string(),
              loaded.report.grid,
              hash.bytes,
              hash.hash,
              loaded.report.non_finite,
              loaded.report.negative,
              loaded.report.type == "double" ? "double" : ""};
  m.unit = o.unit;
  m.options = {{"density", o.closed_form ? "reference" : o.density},
               {"micro_bounds", o.micro_bounds},
               {"closed_form", o.closed_form ? "yes" : "no"},
               {"interpolation", name(look_up)},
               {"shells", o.shells},
               {"shell_kind", o.shell_kind},
               {"shell_effort", fmt::to_string(o.shell_effort)}};
  m.written_by = "pvol-fit " PVOL_VERSION;
  return m;
}

bool is_quantised(const FitOptions& o) { return o.density != "fp32" && o.density != "reference"; }

void quantise_density(const FitOptions& o, formats::LoadedGrid& loaded, formats::PvolFile& file) {
  Quantisation how{find_named<Precision>(o.density).value()};
  if (o.tolerance) how.tolerance = *o.tolerance;
  file.codes = quantise(loaded.grid, how);
  loaded.grid = decode(*file.codes);
}

namespace {

/// What the velocities of a recipe are called in the file: a usual name, by which they are found.
constexpr const char* kFlow = "v";

/// Whether a name means velocities: three components where no grid of numbers has it itself.
bool is_velocity(const std::vector<formats::GridEntry>& grids, const std::string& name) {
  const auto is_grid = [&](const formats::GridEntry& g) { return g.usable && g.name == name; };
  const bool usual = std::ranges::find(formats::kUsualVelocities, name) !=
                     std::ranges::end(formats::kUsualVelocities);
  return std::ranges::none_of(grids, is_grid) && formats::has_velocity(grids, name) &&
         (usual || formats::usual_color_grid(grids) != name);
}

/// "density" of "density[1]": what a further grid of a name would be called in the file.
std::string name_in_file(const std::string& grid) { return grid.substr(0, grid.find('[')); }

/// All grids of numbers but the components of vectors, one of each name, and not the density's.
std::vector<std::string> all_numbers(const std::vector<formats::GridEntry>& grids,
                                     const std::string& taken,
                                     const std::vector<std::string>& vectors) {
  std::vector<std::string> names, called{name_in_file(taken)};
  for (const formats::GridEntry& g : grids) {
    const auto is_of = [&](const std::string& v) {
      return !v.empty() && formats::is_component(g.name, v);
    };
    if (!g.usable || g.name == taken || std::ranges::any_of(vectors, is_of)) continue;
    const std::string name = name_in_file(g.name);
    if (std::ranges::count(called, name) > 0) {
      print_warnings("pvol-fit", {"the grid " + g.name + " is left out: another one has its name"});
      continue;
    }
    names.push_back(g.name), called.push_back(name);
  }
  return names;
}

/// The grids that go into the file besides the density, which is `taken`.
std::vector<std::string> choose_fields(const FitOptions& o, const std::string& taken) {
  if (o.fields == "none") return {};
  if (formats::ending(o.input) == ".toml") {
    return formats::read_flow(o.input) ? std::vector<std::string>{kFlow}
                                       : std::vector<std::string>{};
  }
  const std::vector<formats::GridEntry> grids = formats::grids_of(o.input);
  std::vector<std::string> names;
  const std::string color =
      formats::ending(o.input) == ".vdb" ? formats::usual_color_grid(grids) : "";
  const std::string velocity = formats::usual_velocity(grids);
  if (o.fields == "auto") {
    names = formats::usual_fire_grids(grids);
  } else if (o.fields == "all") {
    names = all_numbers(grids, taken, {color, velocity});
  } else {
    const Value list = parse_value(any_text().times(2), o.fields);
    for (const Value& v : *list.list()) names.push_back(*v.word());
  }
  if ((o.fields == "auto" || o.fields == "all") && !color.empty()) names.push_back(color);
  if (!velocity.empty()) {
    if (o.fields == "all") names.push_back(velocity);
    if (o.fields == "auto") {
      print_warnings("pvol-fit",
                     {"the velocities " + velocity +
                      " are left out; keep them for motion blur with --fields all or their name"});
    }
  }
  std::erase(names, taken);
  return names;
}

/// Adds a further grid to the file, kept as the density is, or in any case.
void add_field(const FitOptions& o, formats::LoadedGrid& loaded, bool embed, Fit& f) {
  formats::PvolFile field;
  if (is_quantised(o)) quantise_density(o, loaded, field);
  field.pyramid = formats::build_bounds(loaded.grid, o.input);
  field.metadata = describe_source(o, loaded, field.pyramid.look_up);
  if (o.density == "fp32" || (embed && !is_quantised(o))) field.density = loaded.grid;
  f.fields.push_back(loaded.report);
  f.file.fields.push_back(std::move(field));
}

/// Adds colours as grids of their channels. The source has no such grids to refer to.
void add_colors(const FitOptions& o, const std::string& name, Fit& f) {
  formats::LoadedColor loaded = formats::read_color(o.input, name, o.grid.strict);
  print_warnings("pvol-fit", loaded.report.warnings);
  const std::string called = loaded.grid.name();
  const auto add = [&](VoxelGrid& grid, const std::string& part) {
    formats::LoadedGrid channel{std::move(grid), loaded.report};
    channel.grid.name = channel.report.grid = part;
    add_field(o, channel, true, f);
    grid = std::move(channel.grid);  // as it is kept
  };
  const std::vector<std::string> parts = formats::color_parts(called);
  for (std::size_t c = 0; c < 3; ++c) add(loaded.grid.channels[c], parts[c]);
  VoxelGrid black = black_of(loaded.grid);
  if (!black.bricks.empty() || !black.tiles.empty()) add(black, parts[3]);
}

/// Adds velocities as the parts of their components that are above and below 0, in any case.
void add_velocity(const FitOptions& o, const std::string& name, Fit& f) {
  const bool is_recipe = formats::ending(o.input) == ".toml";
  const auto loaded = formats::read_velocity(o.input, is_recipe ? "" : name, o.grid.strict);
  print_warnings("pvol-fit", loaded->warnings);
  std::array<VoxelGrid, 6> parts = signed_parts(loaded->grid);
  const std::vector<std::string> names = formats::velocity_parts(name);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].bricks.empty() && parts[i].tiles.empty()) continue;
    formats::LoadedGrid part{std::move(parts[i]), {}};
    part.grid.name = part.report.grid = names[i];
    part.report.type = "velocity";
    const SampleCount count = count_samples(part.grid);
    part.report.active = count.active, part.report.largest = count.largest;
    add_field(o, part, true, f);
  }
}

/// Adds a grid of the input, of numbers, of colours or of velocities.
void add_field(const FitOptions& o, const std::string& name, Fit& f) {
  if (name == kFlow && formats::ending(o.input) == ".toml") return add_velocity(o, name, f);
  if (formats::ending(o.input) == ".vdb" && is_velocity(formats::grids_of(o.input), name)) {
    return add_velocity(o, name, f);
  }
  if (formats::ending(o.input) == ".vdb" && formats::has_colors(formats::grids_of(o.input), name)) {
    return add_colors(o, name, f);
  }
  formats::LoadedGrid loaded = formats::load_grid(o.input, {name, o.grid.strict});
  print_warnings("pvol-fit", loaded.report.warnings);
  add_field(o, loaded, false, f);
}

}  // namespace

void add_fields(const FitOptions& o, const std::string& taken, Fit& f) {
  for (const std::string& name : choose_fields(o, taken)) add_field(o, name, f);
}

}  // namespace pvol::cli
