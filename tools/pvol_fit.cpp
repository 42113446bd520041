// pvol-fit: a cloud in, a .pvol file with its bounds out.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "cli/cli_app.h"
#include "cli/frames_app.h"
#include "cli/shell_checks.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/color.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_file.h"
#include "pvol/formats/velocity.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/volume/make_volume.h"
#include "stats/fit_report.h"

namespace {

using namespace pvol;

constexpr const char* kTool = "pvol-fit";

constexpr const char* kExamples = R"(Examples:
  pvol-fit cloud.vdb -o cloud.pvol
      the grid named density, with a copy of it in the file
  pvol-fit explosion.vdb --grid temperature --density reference --json -o explosion.pvol
      another grid, small file: rendering will read explosion.vdb again; report as JSON
  pvol-fit cloud.vdb --shells 16 --check -o cloud.pvol
      with a bounding shell of 16 perturbations, proven to hold the cloud and checked again by CGAL
  pvol-fit smoke.####.vdb -o smoke.####.pvol --frames 1-240
      a sequence, frame by frame, with a line for each

The report on stdout tells the grid, its size, the bounds, and the bytes and seconds they took.
Exit status: 0 success, 1 failure, 2 wrong usage.)";

using cli::Fit;
using Options = cli::FitOptions;

void add_files(CLI::App& app, Options& o) {
  app.add_option("INPUT", o.input, "The cloud: .vdb, .nvdb, or a recipe (.toml)")
      ->type_name("")
      ->required();
  app.add_option("-o,--output", o.output, "The .pvol file to write")->type_name("FILE")->required();
  app.add_option("--grid", o.grid.grid,
                 "Grid of a .vdb or .nvdb file; a name that occurs several times takes an index, "
                 "\"density[1]\" [density, else the only float grid]")
      ->type_name("NAME");
  app.add_option(
         "--fields", o.fields,
         "Grids that the file holds besides the density, each with bounds of its own: auto "
         "takes those that fires go by, flames and temperature or the like, and the colours "
         "that albedos go by, Cd or color; all every grid of numbers besides, and velocities, "
         "which "
         "motion blur goes by. Colours are three grids in the file, NAME.x, NAME.y and NAME.z, "
         "velocities up to six, NAME.x+, NAME.x- and so on; those of a recipe's [flow] are always "
         "kept, but with none [auto]")
      ->type_name("auto|all|none|NAME,...");
  app.add_option("--unit", o.unit,
                 "Unit of the world, as a note for readers of the file, e.g. m; extinction is per "
                 "this unit")
      ->type_name("NAME");
}

void add_density(CLI::App& app, Options& o) {
  app.add_option("--density", o.density,
                 "fp32: the file holds every sample, exactly, and works alone; for large clouds it "
                 "is about as large as the source. fp16: halves, fp8: 8 bits of the range of each "
                 "brick of 8^3, fpn: 1 to 16 bits, as few as keep to --density-tolerance; smaller "
                 "files whose pictures are biased, by an error that the report states. reference: "
                 "it holds the source's name, size and hash, less than a hundredth of its bytes, "
                 "and needs it to render [fp32]")
      ->type_name("NAME")
      ->check(cli::fits(name_of<Precision>().or_word("reference")));
  app.add_option(
         "--density-tolerance", o.tolerance,
         fmt::format("Largest error of a sample with --density fpn, relative to the largest "
                     "sample, {} [0.01]",
                     ends_of(number(kToleranceRange))))
      ->type_name("X")
      ->check(cli::fits(number(kToleranceRange)));
}

void add_bounds(CLI::App& app, Options& o) {
  app.add_option("--micro-bounds", o.micro_bounds,
                 "Store bounds of cubes of 2^3 voxels, which save look-ups in fields that miss the "
                 "cache and are else built at load. Those of single voxels are nearly as large as "
                 "the source and never stored: pvol-render --micro-bounds 1 builds them, and those "
                 "of tricubic "
                 "interpolation [none]")
      ->type_name("none|2")
      ->check(cli::one_of({"none", "2", "1"}));
  app.add_option(
         "--interpolation", o.look_up,
         "What the bounds hold for: trilinear (and nearest); tricubic, somewhat looser, which "
         "holds for all three and pvol-render --interpolation tricubic needs [trilinear]")
      ->type_name("trilinear|tricubic")
      ->check(cli::one_of({name(LookUp::trilinear), name(LookUp::tricubic)}));
}

void add_shells(CLI::App& app, Options& o) {
  app.add_option(
         "--shells", o.shells,
         fmt::format("Fit a bounding shell of that many perturbations, 0 to {} (soft: {}), or of "
                     "the number that should cost rays least; takes 1 to 30 seconds and 88 + 44 K "
                     "bytes [none]",
                     kMaxPerturbations, kMaxSoftPerturbations))
      ->type_name("K|auto|none")
      ->check(cli::word_or_number({"auto", "none"}, kMaxPerturbations));
  app.add_option(
         "--shell-kind", o.shell_kind,
         "hard: an ellipsoid with quadrics cut away, fast for rays. soft: a smooth surface, "
         "tests take twice as long [hard]")
      ->type_name("hard|soft")
      ->check(cli::one_of({"hard", "soft"}));
  app.add_option("--shell-effort", o.shell_effort,
                 "Factor on the work of fitting a shell, 1 to 10 [1]")
      ->type_name("N")
      ->check(CLI::Range(1, 10).description(""));
  app.add_flag(
      "--check", o.check,
      "Check the shell with CGAL in exact arithmetic, independently of its certificate, and "
      "report distances; a shell that fails is not written");
}

std::optional<int> read_command_line(int argc, char** argv, Options& o) {
  CLI::App app{"Fits bounds to a cloud and writes them, with its density, to a .pvol file.", kTool};
  cli::add_common(app, kExamples);
  cli::add_quiet(app, o.common);
  add_files(app, o);
  cli::add_frames(app, o.frames);
  add_density(app, o);
  add_bounds(app, o);
  add_shells(app, o);
  app.add_flag(
      "--closed-form", o.closed_form,
      "Bound a recipe by its formulas, without sampling it. Bounds are looser, and the density "
      "stays in the recipe, which a render samples");
  app.add_flag("--strict", o.grid.strict,
               "Refuse an input that draws a warning: non-finite or negative densities, say");
  app.add_flag("--json", o.json, "The report as JSON");
  app.add_option("--threads", o.threads, "Threads; 0 is one for each hardware thread [0]")
      ->type_name("N")
      ->check(cli::fits(whole(0, kMostThreads)));
  return cli::parse(app, argc, argv);
}

/// Of a grid of the input, whose bounds were made for an interpolation.
formats::Metadata describe_source(const Options& o, const formats::LoadedGrid& loaded,
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

void add_shell(const Options& o, Fit& f) {
  // In closed form by cubes of the size that the bounds were refined to, so that the boxes agree.
  const Support support = o.closed_form ? make_support(f.recipe, 3 - kLeafRefinement)
                                        : make_support(f.loaded.grid, f.file.pyramid);
  ShellOptions options;
  options.kind = o.shell_kind == "soft" ? ShellKind::soft : ShellKind::hard;
  if (o.shells != "auto") options.perturbations = std::stoi(o.shells);
  options.effort = o.shell_effort;
  options.index_to_world = f.loaded.grid.index_to_world;
  cli::ProgressBar bar("fitting the shell", "steps", o.common.quiet);
  f.file.shell = cli::naming(o.input, [&] {
    return fit_shell(support, options,
                     [&](std::uint64_t done, std::uint64_t total) { bar.show(done, total); });
  });
  if (o.check)
    f.check = cli::naming(o.input, [&] { return cli::check_shell(*f.file.shell, support).text; });
}

bool is_quantised(const Options& o) { return o.density != "fp32" && o.density != "reference"; }

/// Turns the samples into codes and from there on takes what these stand for as the density.
void quantise_density(const Options& o, formats::LoadedGrid& loaded, formats::PvolFile& file) {
  Quantisation how{find_named<Precision>(o.density).value()};
  if (o.tolerance) how.tolerance = *o.tolerance;
  file.codes = quantise(loaded.grid, how);
  loaded.grid = decode(*file.codes);
}

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

/// The grids that go into the file besides the density, which is `taken`.
std::vector<std::string> choose_fields(const Options& o, const std::string& taken) {
  if (o.fields == "none") return {};
  if (formats::ending(o.input) == ".toml") {
    return formats::read_flow(o.input) ? std::vector<std::string>{kFlow}
                                       : std::vector<std::string>{};
  }
  const std::vector<formats::GridEntry> grids = formats::grids_of(o.input);
  std::vector<std::string> names;
  const std::string color =
      formats::ending(o.input) == ".vdb" ? formats::usual_color_grid(grids) : "";
  if (o.fields == "auto") {
    names = formats::usual_fire_grids(grids);
  } else if (o.fields == "all") {
    for (const formats::GridEntry& g : grids) {
      if (g.usable) names.push_back(g.name);
    }
  } else {
    const Value list = parse_value(any_text().times(2), o.fields);
    for (const Value& v : *list.list()) names.push_back(*v.word());
  }
  if ((o.fields == "auto" || o.fields == "all") && !color.empty()) names.push_back(color);
  if (const std::string velocity = formats::usual_velocity(grids); !velocity.empty()) {
    if (o.fields == "all") names.push_back(velocity);
    if (o.fields == "auto") {
      cli::print_warnings(kTool, {"the velocities " + velocity +
                                  " are left out; --fields all, or "
                                  "their name there, keeps them for motion blur"});
    }
  }
  std::erase(names, taken);
  return names;
}

/// Adds a further grid to the file, kept as the density is, or in any case.
void add_field(const Options& o, formats::LoadedGrid& loaded, bool embed, Fit& f) {
  formats::PvolFile field;
  if (is_quantised(o)) quantise_density(o, loaded, field);
  field.pyramid = formats::build_bounds(loaded.grid, o.input);
  field.metadata = describe_source(o, loaded, field.pyramid.look_up);
  if (o.density == "fp32" || (embed && !is_quantised(o))) field.density = loaded.grid;
  f.fields.push_back(loaded.report);
  f.file.fields.push_back(std::move(field));
}

/// Adds colours as grids of their channels. The source has no such grids to refer to.
void add_colors(const Options& o, const std::string& name, Fit& f) {
  formats::LoadedColor loaded = formats::read_color(o.input, name, o.grid.strict);
  cli::print_warnings(kTool, loaded.report.warnings);
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
void add_velocity(const Options& o, const std::string& name, Fit& f) {
  const bool is_recipe = formats::ending(o.input) == ".toml";
  const auto loaded = formats::read_velocity(o.input, is_recipe ? "" : name, o.grid.strict);
  cli::print_warnings(kTool, loaded->warnings);
  std::array<VoxelGrid, 6> parts = signed_parts(loaded->grid);
  const std::vector<std::string> names = formats::velocity_parts(name);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].bricks.empty() && parts[i].tiles.empty()) continue;
    formats::LoadedGrid part{std::move(parts[i]), {}};
    part.grid.name = part.report.grid = names[i];
    part.report.type = "velocity";
    add_field(o, part, true, f);
  }
}

/// Adds a grid of the input, of numbers, of colours or of velocities.
void add_field(const Options& o, const std::string& name, Fit& f) {
  if (name == kFlow && formats::ending(o.input) == ".toml") return add_velocity(o, name, f);
  if (formats::ending(o.input) == ".vdb" && is_velocity(formats::grids_of(o.input), name)) {
    return add_velocity(o, name, f);
  }
  if (formats::ending(o.input) == ".vdb" && formats::has_colors(formats::grids_of(o.input), name)) {
    return add_colors(o, name, f);
  }
  formats::LoadedGrid loaded = formats::load_grid(o.input, {name, o.grid.strict});
  add_field(o, loaded, false, f);
}

/// The density; nothing of a file that is a fire alone.
formats::LoadedGrid load_density(const Options& o) {
  const bool open = o.grid.grid.empty() && o.fields != "none";
  if (open && formats::ending(o.input) != ".toml") {
    const std::vector<formats::GridEntry> grids = formats::grids_of(o.input);
    if (formats::lacks_density(grids) && !formats::usual_fire_grids(grids).empty()) {
      formats::LoadedGrid nothing;
      nothing.grid.name = nothing.report.grid = "density";
      nothing.report.type = "none";
      nothing.report.warnings.emplace_back(
          "no grid is called density: the file holds a fire alone; take a grid for the density "
          "with --grid NAME");
      return nothing;
    }
  }
  return formats::load_grid(o.input, o.grid);
}

Fit fit(const Options& o) {
  Fit f;
  cli::Stopwatch watch;
  cli::StageLine stage("reading " + o.input.filename().string(), o.common.quiet);
  if (o.closed_form) {
    f.recipe = formats::read_recipe(o.input);
    f.loaded.grid.name = f.loaded.report.grid = f.recipe.name;
    f.loaded.grid.index_to_world = scaling(Vec3d(f.recipe.voxel));
    f.loaded.report.type = "recipe, not sampled";
  } else {
    f.loaded = load_density(o);
  }
  f.read_seconds = watch.lap();
  stage.show("building bounds");
  if (is_quantised(o)) quantise_density(o, f.loaded, f.file);
  f.file.pyramid = o.closed_form ? cli::naming(o.input, [&] { return build_pyramid(f.recipe); })
                                 : formats::build_bounds(f.loaded.grid, o.input,
                                                         find_named<LookUp>(o.look_up).value());
  if (o.micro_bounds == "2") {
    f.file.micro = build_leaf_micro_bounds(f.loaded.grid, f.file.pyramid, 2);
  }
  if (!o.closed_form) {
    for (const std::string& grid : choose_fields(o, f.loaded.report.grid)) add_field(o, grid, f);
  }
  stage.erase();
  f.bounds_seconds = watch.lap();
  if (o.shells != "none" && !f.file.pyramid.empty()) {
    add_shell(o, f);
    f.shell_seconds = watch.lap();
  }
  stage.show("writing " + o.output.filename().string());
  f.file.metadata = describe_source(o, f.loaded, f.file.pyramid.look_up);
  f.source_bytes = f.file.metadata.source.bytes;
  const bool embeds = o.density == "fp32" || f.loaded.report.type == "none";
  if (embeds && !o.closed_form) f.file.density = f.loaded.grid;
  f.bytes = formats::write_pvol(o.output, f.file);
  f.write_seconds = watch.lap();
  return f;
}

/// Refuses what the options of density and micro-bounds cannot mean together.
void check_density(const Options& o) {
  if (o.micro_bounds == "1") {
    throw cli::UsageError(
        "--micro-bounds 1: bounds of single voxels would take 70 to 120 % of the source; a file "
        "holds those of 2^3 voxels, and pvol-render --micro-bounds 1 builds single ones at load");
  }
  if (o.closed_form && (o.micro_bounds != "none" || is_quantised(o))) {
    throw cli::UsageError(
        "--closed-form takes no samples: --micro-bounds and --density fp16, fp8 and fpn need them");
  }
  if (o.tolerance && o.density != "fpn") {
    throw cli::UsageError("--density-tolerance goes with --density fpn");
  }
}

/// Refuses what the command line cannot mean, before any work.
void check_options(const Options& o) {
  const std::string kind = formats::ending(o.input);
  if (kind != ".vdb" && kind != ".nvdb" && kind != ".toml") {
    throw cli::UsageError(
        fmt::format("the input {} ends in '{}', expected .vdb, .nvdb or .toml (a recipe)",
                    o.input.string(), kind));
  }
  if (o.closed_form && kind != ".toml") {
    throw cli::UsageError(
        fmt::format("--closed-form is for recipes (.toml); {} holds samples", o.input.string()));
  }
  check_density(o);
  if (o.closed_form && !o.grid.grid.empty()) {
    throw cli::UsageError("--grid does not go with --closed-form: a recipe makes one grid");
  }
  if (o.closed_form && o.look_up == "tricubic") {
    throw cli::UsageError(
        "--closed-form bounds the recipe itself, for procedural, trilinear and nearest look-ups; "
        "leave it out for --interpolation tricubic");
  }
  if (o.shell_kind == "soft" && o.shells != "none" && o.shells != "auto" &&
      std::stoi(o.shells) > kMaxSoftPerturbations) {
    throw cli::UsageError(fmt::format("--shells {}: a soft shell has at most {} perturbations",
                                      o.shells, kMaxSoftPerturbations));
  }
  if (o.check && !cli::can_check_shells()) {
    throw cli::UsageError("this pvol was built without CGAL, which --check needs");
  }
  if (o.check && o.shells == "none") {
    throw cli::UsageError("--check checks the shell that --shells asks for; add --shells auto");
  }
}

/// Without `label` the cloud is alone, else a frame of a sequence.
int fit_and_report(const Options& o, const std::string& label = "") {
  const Fit f = fit(o);
  cli::print_warnings(kTool, f.loaded.report.warnings);
  cli::print_warnings(kTool, doubts(o, f));
  if (o.json) {
    cli::print_json(o, f);
  } else if (!o.common.quiet) {
    label.empty() ? cli::print_text(o, f) : cli::print_line(o, f, label);
  }
  return cli::kSuccess;
}

Options options_of_frame(const Options& o, int frame) {
  Options one = o;
  one.input = cli::file_of_frame(o.input, frame);
  one.output = cli::file_of_frame(o.output, frame);
  one.frames = {.frame = frame};
  return one;
}

int run(const Options& o) {
  cli::check_frames(o.frames);
  check_options(o);
  cli::check_output(o.output, {".pvol"});
  std::optional<tbb::global_control> limit;
  if (o.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(o.threads));
  }

  if (!o.frames.any()) {
    cli::refuse_pattern(o.input);
    return fit_and_report(o);
  }
  return cli::for_each_file({kTool, o.common.quiet}, o.frames, o.input, o.output,
                            [&](int frame, const std::string& label) {
                              return fit_and_report(options_of_frame(o, frame), label);
                            });
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const auto code = read_command_line(argc, argv, options)) return *code;
  return cli::run_guarded(kTool, [&] { return run(options); });
}
