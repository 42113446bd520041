// pvol-fit: a cloud in, a .pvol file with its bounds out.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "cli/command_line.h"
#include "cli/frames_line.h"
#include "cli/interrupt.h"
#include "cli/shell_checks.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_file.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/volume/make_volume.h"
#include "stats/fit_fields.h"
#include "stats/fit_report.h"

namespace {

using namespace pvol;

constexpr const char* kTool = "pvol-fit";

constexpr const char* kExamples = R"(Examples:
  pvol-fit cloud.vdb -o cloud.pvol
      the grid named density, with a copy of it in the file
  pvol-fit explosion.vdb --grid temperature --density reference --json -o explosion.pvol
      another grid in a small file: rendering reads explosion.vdb again; report as JSON
  pvol-fit cloud.vdb --shells 16 --check -o cloud.pvol
      with a bounding shell of 16 perturbations, proven to contain the cloud and checked by CGAL
  pvol-fit smoke.####.vdb -o smoke.####.pvol --frames 1-240
      a sequence, frame by frame, with a line for each

The report on stdout gives the grid, its size, the bounds, and their bytes and seconds.
Exit status: 0 success, 1 failure, 2 wrong usage.)";

using cli::Fit;
using Options = cli::FitOptions;

void add_files(const cli::CommandLine& app, Options& o) {
  app.add_option("INPUT", o.input, "Cloud: .vdb, .nvdb, or a recipe (.toml)")
      .type_name("")
      .required();
  app.add_option("-o,--output", o.output, "File to write (.pvol)").type_name("FILE").required();
  app.add_option("--grid", o.grid.grid,
                 "Grid of a .vdb or .nvdb file; a name that occurs several times needs an index, "
                 "\"density[1]\" [density, else the only float grid]")
      .type_name("NAME");
  app.add_option(
         "--fields", o.fields,
         "Grids that the file holds in addition to the density, each with its own bounds. auto: "
         "grids of fires, flames and temperature or the like, and colours of the albedo, Cd or "
         "color. all: also every other grid of numbers, and velocities for motion blur. Colours "
         "are three grids in the file, NAME.x, NAME.y and NAME.z, velocities up to six, NAME.x+, "
         "NAME.x- and so on; those of a recipe's [flow] are always kept, except with none [auto]")
      .type_name("auto|all|none|NAME,...");
  app.add_option(
         "--unit", o.unit,
         "World unit, as a note for readers of the file, e.g. m; extinction is per this unit")
      .type_name("NAME");
}

void add_density(const cli::CommandLine& app, Options& o) {
  app.add_option("--density", o.density,
                 "fp32: the file holds every sample exactly and needs no other file; for large "
                 "clouds it is about as large as the source. fp16: halves, fp8: 8 bits of the "
                 "range of each brick of 8^3, fpn: 1 to 16 bits, as few as --density-tolerance "
                 "allows; smaller files whose pictures are biased, by an error that the report "
                 "states. reference: only the source's name, size and hash, less than a hundredth "
                 "of its bytes; rendering needs the source [fp32]")
      .type_name("NAME")
      .check(cli::fits(name_of<Precision>().or_word("reference")));
  app.add_option(
         "--density-tolerance", o.tolerance,
         fmt::format("Largest error of a sample with --density fpn, relative to the largest "
                     "sample, {} [0.01]",
                     ends_of(number(kToleranceRange))))
      .type_name("X")
      .check(cli::fits(number(kToleranceRange)));
  app.add_option("--compression", o.compression,
                 "zstd: the smallest file. none: a file of 2 kB for each 8^3 voxels, whose samples "
                 "renders use where they lie: it is ready sooner, takes no memory for them but the "
                 "system's cache, which several renders share, and may be larger than memory. With "
                 "--density fp32; other precisions are decoded [zstd]")
      .type_name("zstd|none")
      .check(cli::one_of({name(formats::Compression::zstd), name(formats::Compression::none)}));
}

void add_bounds(const cli::CommandLine& app, Options& o) {
  app.add_option("--micro-bounds", o.micro_bounds,
                 "Store bounds of cubes of 2^3 voxels, which save look-ups in fields that miss the "
                 "cache and are otherwise built at load. Those of single voxels are nearly as "
                 "large as the source and never stored: pvol-render --micro-bounds 1 builds them, "
                 "and those of tricubic interpolation [none]")
      .type_name("none|2")
      .check(cli::one_of({"none", "2", "1"}));
  app.add_option("--interpolation", o.look_up,
                 "Interpolation for which the bounds hold: trilinear (and nearest), or tricubic, "
                 "whose bounds are somewhat looser, hold for all three and are needed by "
                 "pvol-render --interpolation tricubic [trilinear]")
      .type_name("trilinear|tricubic")
      .check(cli::one_of({name(LookUp::trilinear), name(LookUp::tricubic)}));
}

void add_shells(const cli::CommandLine& app, Options& o) {
  app.add_option(
         "--shells", o.shells,
         fmt::format(
             "Fit a bounding shell of K perturbations, 0 to {} (soft: {}), or auto, the number at "
             "which rays should cost least; takes 1 to 30 seconds and 88 + 44 K bytes [none]",
             kMaxPerturbations, kMaxSoftPerturbations))
      .type_name("K|auto|none")
      .check(cli::word_or_number({"auto", "none"}, kMaxPerturbations));
  app.add_option("--shell-kind", o.shell_kind,
                 "hard: an ellipsoid from which quadrics are cut, fast for rays. soft: a smooth "
                 "surface, whose tests take twice as long [hard]")
      .type_name("hard|soft")
      .check(cli::one_of({"hard", "soft"}));
  app.add_option("--shell-effort", o.shell_effort,
                 "Factor on the work of fitting a shell, 1 to 10 [1]")
      .type_name("N")
      .check(cli::fits(whole(1, 10)));
  app.add_flag(
      "--check", o.check,
      "Check the shell with CGAL in exact arithmetic, independently of its certificate, and "
      "report distances; a shell that fails is not written");
}

std::optional<int> read_command_line(int argc, char** argv, Options& o) {
  const cli::CommandLine app(
      "Fits bounds to a cloud and writes them, with its density, to a .pvol file.", kTool,
      kExamples);
  cli::add_quiet(app, o.common);
  add_files(app, o);
  cli::add_frames(app, o.frames);
  add_density(app, o);
  add_bounds(app, o);
  add_shells(app, o);
  app.add_flag("--closed-form", o.closed_form,
               "Bound a recipe by its formulas, without sampling it. Bounds are looser, and the "
               "density stays in the recipe, which is sampled when rendering");
  app.add_flag("--strict", o.grid.strict,
               "Refuse an input that causes a warning, such as non-finite or negative densities");
  app.add_flag("--json", o.json, "Print the report as JSON");
  app.add_option("--threads", o.threads, "Number of threads; 0 is one for each hardware thread [0]")
      .type_name("N")
      .check(cli::fits(whole(0, kMostThreads)));
  return app.parse(argc, argv);
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
          "no grid is called density: the file holds only a fire; choose a grid for the density "
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
  if (cli::is_quantised(o)) cli::quantise_density(o, f.loaded, f.file);
  f.file.pyramid = o.closed_form ? cli::naming(o.input, [&] { return build_pyramid(f.recipe); })
                                 : formats::build_bounds(f.loaded.grid, o.input,
                                                         find_named<LookUp>(o.look_up).value());
  if (o.micro_bounds == "2") {
    f.file.micro = build_leaf_micro_bounds(f.loaded.grid, f.file.pyramid, 2);
  }
  if (!o.closed_form) cli::add_fields(o, f.loaded.report.grid, f);
  stage.erase();
  f.bounds_seconds = watch.lap();
  if (o.shells != "none" && !f.file.pyramid.empty()) {
    add_shell(o, f);
    f.shell_seconds = watch.lap();
  }
  stage.show("writing " + o.output.filename().string());
  f.file.metadata = cli::describe_source(o, f.loaded, f.file.pyramid.look_up);
  f.source_bytes = f.file.metadata.source.bytes;
  const bool embeds = o.density == "fp32" || f.loaded.report.type == "none";
  if (embeds && !o.closed_form) f.file.density = f.loaded.grid;
  f.bytes = formats::write_pvol(o.output, f.file,
                                find_named<formats::Compression>(o.compression).value());
  f.write_seconds = watch.lap();
  return f;
}

/// Refuses what the options of density and micro-bounds cannot mean together.
void check_density(const Options& o) {
  if (o.micro_bounds == "1") {
    throw cli::UsageError(
        "--micro-bounds 1: bounds of single voxels would take 70 to 120 % of the source; store "
        "those of 2^3 voxels, and let pvol-render --micro-bounds 1 build single ones at load");
  }
  if (o.closed_form && (o.micro_bounds != "none" || cli::is_quantised(o))) {
    throw cli::UsageError(
        "--closed-form takes no samples, but --micro-bounds and --density fp16, fp8 and fpn need "
        "them; leave one of them out");
  }
  if (o.tolerance && o.density != "fpn") {
    throw cli::UsageError("--density-tolerance needs --density fpn");
  }
  if (o.compression == "none" && (o.closed_form || o.density == "reference")) {
    throw cli::UsageError(
        "--compression none lets renders use samples where they lie, but with --closed-form and "
        "--density reference the file has none; leave it out");
  }
}

/// Refuses what the command line cannot mean, before any work.
void check_options(const Options& o) {
  formats::refuse_folder(o.input, "a .vdb, .nvdb or .toml (a recipe)");
  const std::string kind = formats::ending(o.input);
  if (kind != ".vdb" && kind != ".nvdb" && kind != ".toml") {
    throw cli::UsageError(
        fmt::format("the input {} ends in '{}', expected .vdb, .nvdb or .toml (a recipe)",
                    o.input.string(), kind));
  }
  if (o.closed_form && kind != ".toml") {
    throw cli::UsageError(fmt::format("--closed-form is for recipes (.toml), but {} holds samples",
                                      o.input.string()));
  }
  check_density(o);
  if (kind == ".toml" && o.fields != "auto" && o.fields != "all" && o.fields != "none") {
    throw cli::UsageError(fmt::format(
        "--fields {}: expected auto, all or none: besides its density a recipe has only a [flow]",
        o.fields));
  }
  if (o.closed_form && !o.grid.grid.empty()) {
    throw cli::UsageError(
        "--grid and --closed-form exclude each other: a recipe has only one grid");
  }
  if (o.closed_form && o.look_up == "tricubic") {
    throw cli::UsageError(
        "--closed-form bounds the recipe itself, for procedural, trilinear and nearest look-ups; "
        "leave it out for --interpolation tricubic");
  }
  if (o.shell_kind == "soft" && o.shells != "none" && o.shells != "auto" &&
      std::stoi(o.shells) > kMaxSoftPerturbations) {
    throw cli::UsageError(
        fmt::format("--shells {}: expected at most {} perturbations of a soft shell", o.shells,
                    kMaxSoftPerturbations));
  }
  if (o.check && o.shells == "none") {
    throw cli::UsageError("--check needs a shell to check; add --shells auto");
  }
  if (o.shells == "none" && (o.shell_kind != "hard" || o.shell_effort != 1)) {
    throw cli::UsageError(
        "--shell-kind and --shell-effort are those of a shell; add --shells auto");
  }
  if (o.check && !cli::can_check_shells()) {
    throw cli::UsageError("this pvol was built without CGAL, which --check needs");
  }
}

/// Without `label` the cloud is alone, else a frame of a sequence.
int fit_and_report(const Options& o, const std::string& label = "") {
  const Fit f = fit(o);
  cli::print_warnings(kTool, warnings(o, f));
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
    cli::refuse_pattern(o.output);
    return fit_and_report(o);
  }
  cli::require_pattern({o.input});
  return cli::for_each_file({kTool, o.common.quiet}, o.frames, o.input, o.output,
                            [&](int frame, const std::string& label) {
                              return fit_and_report(options_of_frame(o, frame), label);
                            });
}

}  // namespace

int main(int argc, char** argv) {
  cli::watch_signals(kTool);
  return cli::run_guarded(kTool, [&] {
    Options options;
    const auto code = read_command_line(argc, argv, options);
    return code ? *code : run(options);
  });
}
