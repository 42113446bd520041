// pvol-fit: a cloud in, a .pvol file with its bounds out.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cmath>
#include <iostream>

#include "cli/cli_app.h"
#include "cli/shell_checks.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_file.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/volume/make_volume.h"
#include "stats/shell_report.h"

namespace {

using namespace pvol;

constexpr const char* kExamples = R"(Examples:
  pvol-fit cloud.vdb -o cloud.pvol
      the grid named density, with a copy of it in the file
  pvol-fit explosion.vdb --grid temperature --density reference --json -o explosion.pvol
      another grid, small file: rendering will read explosion.vdb again; report as JSON
  pvol-fit cloud.vdb --shells 16 --check -o cloud.pvol
      with a bounding shell of 16 perturbations, proven to hold the cloud and checked again by CGAL

The report on stdout tells the grid, its size, the bounds, and the bytes and seconds they took.
Exit status: 0 success, 1 failure, 2 wrong usage.)";

struct Options {
  cli::Common common;
  std::filesystem::path input, output;
  formats::GridOptions grid;
  std::string unit;
  std::string density = "fp32", look_up = "trilinear";
  std::optional<double> tolerance;
  std::string micro_bounds = "none";
  std::string shells = "none", shell_kind = "hard";
  int shell_effort = 1;
  bool check = false, closed_form = false;
  bool json = false;
  int threads = 0;
};

void add_files(CLI::App& app, Options& o) {
  app.add_option("INPUT", o.input, "The cloud: .vdb, .nvdb, or a recipe (.toml)")
      ->type_name("")
      ->required();
  app.add_option("-o,--output", o.output, "The .pvol file to write")->type_name("FILE")->required();
  app.add_option("--grid", o.grid.grid,
                 "Grid of a .vdb or .nvdb file; a name that occurs several times takes an index, "
                 "\"density[1]\" [density, else the only float grid]")
      ->type_name("NAME");
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
  CLI::App app{"Fits bounds to a cloud and writes them, with its density, to a .pvol file.",
               "pvol-fit"};
  cli::add_common(app, kExamples);
  cli::add_quiet(app, o.common);
  add_files(app, o);
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

struct Fit {
  formats::LoadedGrid loaded;  ///< without samples where the bounds are a recipe's in closed form
  Recipe recipe;               ///< of those
  formats::PvolFile file;
  formats::PvolSizes bytes;
  std::uint64_t source_bytes = 0;
  double read_seconds = 0, bounds_seconds = 0, shell_seconds = 0, write_seconds = 0;
  std::string check;  ///< what CGAL's check found
};

formats::Metadata describe_source(const Options& o, const Fit& f) {
  const formats::LoadedGrid& loaded = f.loaded;
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
               {"interpolation", name(f.file.pyramid.look_up)},
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
void quantise_density(const Options& o, Fit& f) {
  Quantisation how{find_named<Precision>(o.density).value()};
  if (o.tolerance) how.tolerance = *o.tolerance;
  f.file.codes = quantise(f.loaded.grid, how);
  f.loaded.grid = decode(*f.file.codes);
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
    f.loaded = formats::load_grid(o.input, o.grid);
  }
  f.read_seconds = watch.lap();
  stage.show("building bounds");
  if (is_quantised(o)) quantise_density(o, f);
  f.file.pyramid = o.closed_form ? cli::naming(o.input, [&] { return build_pyramid(f.recipe); })
                                 : formats::build_bounds(f.loaded.grid, o.input,
                                                         find_named<LookUp>(o.look_up).value());
  if (o.micro_bounds == "2") {
    f.file.micro = build_leaf_micro_bounds(f.loaded.grid, f.file.pyramid, 2);
  }
  stage.erase();
  f.bounds_seconds = watch.lap();
  if (o.shells != "none" && !f.file.pyramid.empty()) {
    add_shell(o, f);
    f.shell_seconds = watch.lap();
  }
  stage.show("writing " + o.output.filename().string());
  f.file.metadata = describe_source(o, f);
  f.source_bytes = f.file.metadata.source.bytes;
  if (o.density == "fp32" && !o.closed_form) f.file.density = f.loaded.grid;
  f.bytes = formats::write_pvol(o.output, f.file);
  f.write_seconds = watch.lap();
  return f;
}

std::uint64_t count_nodes(const Pyramid& p) {
  std::uint64_t n = 0;
  for (const auto& level : p.levels) n += level.size();
  return n;
}

std::size_t count_leaves(const Pyramid& p) { return p.empty() ? 0 : p.levels[0].size(); }
std::size_t depth(const Pyramid& p) { return p.empty() ? 0 : p.levels.size() - 1; }
Vec3l extent(const Pyramid& p) { return p.empty() ? Vec3l{} : p.support_hi - p.support_lo; }
Vec3d extent_world(const Fit& f) {
  if (f.file.pyramid.empty()) return {};
  return transform(f.loaded.grid.index_to_world, f.file.pyramid.support()).extent();
}

/// How far samples are off the exact ones.
std::string error_text(const QuantisationError& e) {
  if (e.absolute == 0) return ", exact for this cloud";
  return fmt::format(", biased: samples are off by up to {}, their sum by {} %",
                     cli::readable(e.absolute), cli::readable(100 * e.mass));
}

void report_text(const Options& o, const Fit& f) {
  using namespace cli;
  const Pyramid& p = f.file.pyramid;
  const formats::GridReport& r = f.loaded.report;
  const formats::PvolSizes& bytes = f.bytes;
  const Vec3l cells = extent(p);
  const Vec3d world = extent_world(f);
  std::cout << fmt::format(
      "grid    {} ({}), {}largest density {}\n", r.grid, r.type,
      o.closed_form ? "" : fmt::format("{} active voxels, ", readable_count(r.active)),
      readable(double(o.closed_form ? p.scale : r.largest)));
  std::cout << fmt::format("support {} x {} x {} voxels, {} x {} x {} world units\n", cells.x,
                           cells.y, cells.z, readable(world.x), readable(world.y),
                           readable(world.z));
  std::cout << fmt::format("bounds  {} leaves of 8^3 voxels, {} nodes, octree depth {}\n",
                           readable_count(count_leaves(p)), readable_count(count_nodes(p)),
                           depth(p));
  if (f.file.codes) {
    std::cout << fmt::format("density {}{}\n", o.density, error_text(f.file.codes->error));
  }
  if (f.file.shell) print_shell(std::cout, *f.file.shell, bytes.shell, "shell   ");
  std::cout << f.check
            << fmt::format(
                   "bytes   {}: bounds {}, micro-bounds {}, shell {}, density {}, "
                   "header and metadata {}; the source has {}\n",
                   readable_bytes(bytes.total), readable_bytes(bytes.bounds),
                   readable_bytes(bytes.micro), readable_bytes(bytes.shell),
                   readable_bytes(bytes.density), readable_bytes(bytes.header + bytes.metadata),
                   readable_bytes(f.source_bytes))
            << fmt::format("time    read {}, bounds {}, shell {}, write {}\n",
                           readable_seconds(f.read_seconds), readable_seconds(f.bounds_seconds),
                           readable_seconds(f.shell_seconds), readable_seconds(f.write_seconds))
            << fmt::format("wrote   {}\n", o.output.string());
}

void report_json(const Options& o, const Fit& f) {
  const Pyramid& p = f.file.pyramid;
  const formats::GridReport& r = f.loaded.report;
  const Vec3l cells = extent(p);
  const Vec3d world = extent_world(f);
  cli::Json j;
  j["input"] = o.input.string();
  j["output"] = o.output.string();
  j["grid"] = {{"name", r.grid},
               {"type", r.type},
               {"active_voxels", r.active},
               {"non_finite", r.non_finite},
               {"negative", r.negative},
               {"largest", o.closed_form ? p.scale : r.largest}};
  j["support_voxels"] = {cells.x, cells.y, cells.z};
  j["support_world"] = {world.x, world.y, world.z};
  j["bounds"] = {{"leaves", count_leaves(p)}, {"nodes", count_nodes(p)}, {"depth", depth(p)}};
  j["density"] = {{"precision", o.closed_form ? "reference" : o.density}};
  if (f.file.codes) {
    const QuantisationError& e = f.file.codes->error;
    j["density"]["absolute_error"] = e.absolute;
    j["density"]["relative_error"] = e.relative;
    j["density"]["mass_error"] = e.mass;
    if (o.density == "fpn") j["density"]["tolerance"] = f.file.codes->how.tolerance;
  }
  if (!f.check.empty()) j["check"] = f.check;
  if (f.file.shell) j["shell"] = cli::to_json(*f.file.shell, f.bytes.shell);
  j["bytes"] = {{"header", f.bytes.header}, {"metadata", f.bytes.metadata},
                {"bounds", f.bytes.bounds}, {"micro", f.bytes.micro},
                {"shell", f.bytes.shell},   {"density", f.bytes.density},
                {"total", f.bytes.total},   {"source", f.source_bytes}};
  j["seconds"] = {{"read", f.read_seconds},
                  {"bounds", f.bounds_seconds},
                  {"shell", f.shell_seconds},
                  {"write", f.write_seconds}};
  j["warnings"] = r.warnings;
  std::cout << cli::to_text(j);
}

/// What is written and perhaps not what was wanted, in whole sentences.
std::vector<std::string> doubts(const Options& o, const Fit& f) {
  std::vector<std::string> all;
  const auto doubt = [&](std::string text) {
    all.push_back(fmt::format("{}: {}", o.input.string(), std::move(text)));
  };
  if (f.file.pyramid.empty()) doubt("the density is 0 everywhere; nothing will be seen");
  if (f.file.codes) {
    constexpr double kMostMass = 0.01;
    const QuantisationError& e = f.file.codes->error;
    if (std::abs(e.mass) > kMostMass) {
      doubt(fmt::format(
          "--density {} changes the cloud's mass by {} %, because most of it is "
          "fainter than the largest error; {}",
          o.density, cli::readable(100 * e.mass),
          o.density == "fpn" ? "lower --density-tolerance, or take fp16" : "take fp16 or fp32"));
    }
    if (e.absolute == 0 && o.density == "fp16" && f.loaded.report.type == "half") {
      doubt(
          "its samples are halves already: --density fp32 keeps them as exactly, and often in "
          "fewer bytes");
    }
  }
  if (f.file.shell && o.shells != "auto") {
    const std::size_t made = f.file.shell->form.perturbations.size();
    if (made < std::size_t(std::stoi(o.shells))) {
      doubt(fmt::format("the shell has {} of {} perturbations: no other removes an empty cell",
                        made, o.shells));
    }
  }
  try {
    validate_placement(f.loaded.grid.index_to_world, f.file.pyramid);
  } catch (const Error& e) {
    doubt(fmt::format("as it lies in the world it cannot be rendered: {}", e.what()));
  }
  return all;
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

int run(const Options& o) {
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
  cli::check_output(o.output, {".pvol"});
  std::optional<tbb::global_control> limit;
  if (o.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(o.threads));
  }

  const Fit f = fit(o);
  cli::print_warnings("pvol-fit", f.loaded.report.warnings);
  cli::print_warnings("pvol-fit", doubts(o, f));
  if (o.json) {
    report_json(o, f);
  } else if (!o.common.quiet) {
    report_text(o, f);
  }
  return cli::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const auto code = read_command_line(argc, argv, options)) return *code;
  return cli::run_guarded("pvol-fit", [&] { return run(options); });
}
