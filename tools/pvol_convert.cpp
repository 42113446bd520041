// pvol-convert: clouds and their bounds from one file format into another.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "cli/command_line.h"
#include "cli/filter_frames.h"
#include "cli/frames_line.h"
#include "cli/interrupt.h"
#include "cli/json.h"
#include "cli/load_scene.h"
#include "cli/merge.h"
#include "cli/picture_facts.h"
#include "cli/picture_line.h"
#include "cli/shell_export.h"
#include "pvol/bounds/bound_grids.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/color.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/image.h"
#include "pvol/formats/pbrt_scene.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/usda_scene.h"
#include "pvol/formats/velocity.h"
#include "pvol/shell/recipe_support.h"

namespace {

using namespace pvol;

constexpr const char* kTool = "pvol-convert";

constexpr const char* kExamples = R"(The endings of the names determine the conversion:
  .toml (a recipe), .nvdb or .pvol to .vdb; .vdb to .vdb keeps the density or the one --grid names,
  with the values that renders use: non-finite and negative ones become 0. pvol-fit makes .pvol files.
  All grids of a .pvol are written; its colours, NAME.x, NAME.y and NAME.z, become a grid of
  vectors, as do velocities, NAME.x+, NAME.x- and so on, and the [flow] of a recipe.
  Deep .exr to flat .exr: its samples are composited, without a background. A flat .exr to .png, with
  another exposure or tone map than before; with alpha where it was rendered without a background.
  .pbrt, a scene of pbrt-v4, and .usda, a scene of USD as text, to .toml: a scene for pvol-render,
  with the files that it needs; what cannot be converted is listed on stderr and at the top of the
  scene. Of a USD scene, --frame and --frames take frames; without them it is startTimeCode.
  .pvol to .ply or .obj: the surface of its shell, in world space; to .png: slices through the cloud
  (grey) and its shell (blue).

Examples:
  pvol-convert samples/cumulus.toml cumulus.vdb
      a procedural cloud for other renderers
  pvol-convert cloud.pvol cloud.vdb --bounds
      the density with its majorants and minorants, for any VDB viewer
  pvol-convert cloud.deep.exr flat.exr
      a deep picture of pvol-render --deep, for programs that need one sample per pixel
  pvol-convert cloud.exr cloud.png --exposure 1 --tone-map filmic
      a picture shown in another way, without rendering it again
  pvol-convert samples/pbrt_scene.pbrt scene.toml && pvol-render scene.toml -o scene.exr
      a scene of pbrt-v4
  pvol-convert shot.usda shot.####.toml --frames 1-240
      scenes of the frames of a scene of USD; binary ones: usdcat -o shot.usda shot.usdc
  pvol-convert cloud.pvol shell.ply --resolution 256
      the bounding shell as triangles
  pvol-convert merge part*.exr -o whole.exr
      a picture from its parts; see pvol-convert merge --help
  pvol-convert denoise noisy.####.exr -o clean.####.exr --frames 1-240
      a sequence without noise and flicker; see pvol-convert denoise --help

Exit status: 0 success, 1 failure, 2 wrong usage.)";

struct Options {
  cli::Common common;
  cli::FramesGiven frames;
  std::filesystem::path input, output;
  formats::GridOptions grid;
  formats::Display display;
  bool bounds = false;
  int resolution = 128;
  bool json = false;
};

std::optional<int> read_command_line(int argc, char** argv, Options& o) {
  const cli::CommandLine app("Converts clouds between file formats.", kTool, kExamples);
  cli::add_quiet(app, o.common);
  app.add_option(
         "INPUT", o.input,
         "Cloud: .toml (a recipe), .nvdb, .pvol or .vdb; a picture: .exr; or a scene: .pbrt or "
         ".usda")
      .type_name("")
      .required();
  app.add_option(
         "OUTPUT", o.output,
         "File to write: .vdb, a shell's .ply, .obj or .png, a flat .exr or a picture's .png, or a "
         "scene: .toml")
      .type_name("")
      .required();
  cli::add_frames(app, o.frames);
  app.add_flag("--bounds", o.bounds,
               "Add the grids majorant and minorant: bounds on the density over cubes of 8^3 "
               "voxels, one voxel at the centre of each cube");
  app.add_option("--resolution", o.resolution,
                 "Number of steps of a shell's mesh along its longest side, 8 to 1024 [128]")
      .type_name("N")
      .check(cli::fits(whole(8, 1024)));
  app.add_option("--grid", o.grid.grid,
                 "Grid of a .vdb or .nvdb file [density, else the only float grid]")
      .type_name("NAME");
  cli::add_display(app, o.display);
  app.add_flag("--strict", o.grid.strict, "Refuse an input that causes a warning");
  app.add_flag("--json", o.json, "Print the report as JSON");
  return app.parse(argc, argv);
}

/// Whether a picture is shown on a screen.
bool shows_picture(const Options& o) {
  return formats::ending(o.input) == ".exr" && formats::ending(o.output) == ".png";
}

/// Whether the output shows a shell.
bool shows_shell(const Options& o) {
  const std::string to = formats::ending(o.output);
  return formats::ending(o.input) == ".pvol" && (to == ".ply" || to == ".obj" || to == ".png");
}

/// Whether it is about pictures.
bool flattens(const Options& o) {
  return formats::ending(o.input) == ".exr" && formats::ending(o.output) == ".exr";
}

/// Whether the input is a scene of USD.
bool is_usd(const Options& o) {
  const std::string from = formats::ending(o.input);
  return from == ".usda" || from == ".usd";
}

/// Whether it is about scenes.
bool imports(const Options& o) {
  return (formats::ending(o.input) == ".pbrt" || is_usd(o)) && formats::ending(o.output) == ".toml";
}

/// The file that a .pvol takes its density from must not be the output. Only where there is a file
/// to lose: a fault of the input is told where it is read.
void check_source(const Options& o) {
  std::error_code missing;
  if (formats::ending(o.input) != ".pvol" || !std::filesystem::exists(o.output, missing) ||
      formats::measure_pvol(o.input).density > 0) {
    return;
  }
  const std::string source = formats::read_pvol_grid(o.input, "").metadata.source.file;
  if (source.empty() || !cli::same_file(o.input.parent_path() / source, o.output)) return;
  throw cli::UsageError(
      fmt::format("{}: holds the density of {}, which the output would replace; choose another "
                  "name for the output",
                  o.output.string(), o.input.string()));
}

void check_pair(const Options& o) {
  const std::string from = formats::ending(o.input), to = formats::ending(o.output);
  const bool readable = from == ".toml" || from == ".nvdb" || from == ".pvol" || from == ".vdb";
  if (!(readable && to == ".vdb") && !shows_shell(o) && !shows_picture(o) && !flattens(o) &&
      !imports(o)) {
    throw cli::UsageError(
        fmt::format("{}: there is no conversion from '{}' to '{}'; expected .toml (a recipe), "
                    ".nvdb, .pvol and .vdb to .vdb, .pvol to .ply, .obj and .png, deep .exr to "
                    "flat, .exr to .png, or .pbrt and .usda to .toml. pvol-fit makes .pvol files.",
                    o.input.string(), from, to));
  }
  if (o.display != formats::Display{} && !shows_picture(o)) {
    throw cli::UsageError("--exposure and --tone-map are for a .png that is made of an .exr");
  }
  cli::check_output(o.output, {".vdb", ".ply", ".obj", ".png", ".exr", ".toml"});
  if (cli::same_file(o.input, o.output)) {
    throw cli::UsageError(
        fmt::format("input and output are the same file, {}; choose another name for the output",
                    o.input.string()));
  }
  check_source(o);
  if (o.bounds && to != ".vdb") {
    throw cli::UsageError("--bounds needs an output that ends in .vdb");
  }
}

/// Active voxels of what was written: zeros are not.
std::uint64_t count_active(const VoxelGrid& grid) {
  std::uint64_t count = 0;
  for (const Brick& b : grid.bricks) {
    count += std::uint64_t(
        std::count_if(b.values, b.values + kBrickSamples, [](float v) { return v > 0; }));
  }
  for (const Tile& t : grid.tiles) {
    const auto edge = std::uint64_t(t.edge);
    if (t.value > 0) count += edge * edge * edge;
  }
  return count;
}

void report(const Options& o, const formats::GridReport& r,
            const std::vector<const VoxelGrid*>& grids,
            const std::vector<std::string>& vectors = {}) {
  if (o.json) {
    cli::Json j;
    j["input"] = o.input.string();
    j["output"] = o.output.string();
    j["grids"] = cli::Json::array();
    for (const VoxelGrid* g : grids) j["grids"].push_back(g->name);
    for (const std::string& name : vectors) j["grids"].push_back(name);
    if (!grids.empty()) j["active_voxels"] = count_active(*grids.front());
    j["bytes"] = std::filesystem::file_size(o.output);
    j["warnings"] = r.warnings;
    std::cout << cli::to_text(j);
  } else if (!o.common.quiet) {
    std::string names = grids.empty() ? "" : ":";
    for (const VoxelGrid* g : grids) names += ' ' + g->name;
    for (const std::string& name : vectors) names += ' ' + name;
    std::cout << fmt::format("wrote {}, {}{}\n", o.output.string(),
                             cli::readable_bytes(std::filesystem::file_size(o.output)), names);
  }
}

const Shell& require_shell(const Options& o, const std::optional<Shell>& shell) {
  if (shell) return *shell;
  throw Error(
      fmt::format("{}: holds no shell; make one with pvol-fit --shells auto", o.input.string()));
}

/// Slices show the density as well; a mesh needs the shell alone.
int convert_shell(const Options& o) {
  formats::GridReport density;
  if (formats::ending(o.output) == ".png") {
    const formats::Cloud cloud = cli::load_cloud({kTool, o.common.quiet}, o.input, o.grid);
    density = cloud.report;
    cli::write_shell_slices(o.output, require_shell(o, cloud.shell),
                            make_support(cloud.grid(), cloud.pyramid));
  } else {
    const formats::PvolFile file = formats::read_pvol_grid(o.input, "");
    cli::write_shell_mesh(o.output, require_shell(o, file.shell), file.metadata.index_to_world,
                          o.resolution);
  }
  report(o, density, {});
  return cli::kSuccess;
}

int convert_picture(const Options& o) {
  const formats::StoredFilm flat = formats::flatten_exr(o.input);
  formats::write_exr(o.output, flat.film, flat.attributes);
  report(o, {}, {});
  return cli::kSuccess;
}

int convert_to_png(const Options& o) {
  formats::use_exr_threads(0);
  const formats::StoredFilm stored = formats::read_film(o.input);
  const bool alpha = cli::attribute(stored.attributes, "pvol:background") == "off";
  formats::write_png(o.output, stored.film, o.display, alpha);
  report(o, {}, {});
  return cli::kSuccess;
}

/// The further grids of a .pvol file.
struct Fields {
  std::vector<formats::LoadedGrid> numbers;
  std::vector<formats::LoadedColor> colors;
  std::vector<formats::LoadedVelocity> velocities;
};

/// Those of a .pvol file where none is asked for by name.
Fields load_fields(const Options& o) {
  Fields fields;
  if (formats::ending(o.input) == ".toml") {
    if (auto flow = formats::read_velocity(o.input, "")) {
      for (VoxelGrid& component : flow->grid.along) component.name = "v";
      fields.velocities.push_back(std::move(*flow));
    }
  }
  if (formats::ending(o.input) != ".pvol" || !o.grid.grid.empty()) return fields;
  const std::vector<formats::GridEntry> grids = formats::grids_of(o.input);
  std::vector<std::string> parts;  // of colours and velocities
  if (const std::string name = formats::usual_velocity(grids); !name.empty()) {
    fields.velocities.push_back(*formats::read_velocity(o.input, name, o.grid.strict));
    parts = formats::velocity_parts(name);
  }
  for (std::size_t i = 1; i < grids.size(); ++i) {
    const std::string& name = grids[i].name;
    const std::string of = name.ends_with(".x") ? name.substr(0, name.size() - 2) : "";
    if (of.empty() || !formats::has_colors(grids, of)) continue;
    fields.colors.push_back(formats::read_color(o.input, of, o.grid.strict));
    for (std::string& part : formats::color_parts(of)) parts.push_back(std::move(part));
  }
  for (std::size_t i = 1; i < grids.size(); ++i) {
    if (std::ranges::find(parts, grids[i].name) != parts.end()) continue;
    fields.numbers.push_back(
        cli::load_grid({kTool, o.common.quiet}, o.input, {grids[i].name, o.grid.strict}));
  }
  return fields;
}

/// Notes go to stderr whole: what is not in the picture is no matter of taste.
int convert_scene(const Options& o) {
  const std::string stem = o.output.stem().string();
  const formats::ImportedScene scene = is_usd(o) ? formats::read_usda(o.input, stem, o.frames.frame)
                                                 : formats::read_pbrt(o.input, stem);
  if (o.grid.strict && !scene.notes.empty()) {
    throw Error(scene.notes.front() + " (refused because of --strict)");
  }
  formats::write_imported(o.output, scene);
  formats::GridReport notes;
  notes.warnings = scene.notes;
  if (!o.common.quiet) {
    for (const std::string& note : scene.notes) std::cerr << kTool << ": " << note << '\n';
  }
  report(o, notes, {});
  return cli::kSuccess;
}

int convert(const Options& o) {
  check_pair(o);
  if (imports(o)) return convert_scene(o);
  if (flattens(o)) return convert_picture(o);
  if (shows_picture(o)) return convert_to_png(o);
  if (shows_shell(o)) return convert_shell(o);
  // Bounds only where they are asked for: building them may refuse what can be converted.
  formats::Cloud cloud;
  BoundGrids bounds;
  std::vector<const VoxelGrid*> grids{&cloud.grid()};
  if (o.bounds) {
    cloud = cli::load_cloud({kTool, o.common.quiet}, o.input, o.grid);
    bounds = cli::naming(
        o.input, [&] { return make_bound_grids(cloud.pyramid, cloud.grid().index_to_world); });
    grids.insert(grids.end(), {&bounds.majorant, &bounds.minorant});
  } else {
    formats::LoadedGrid loaded = cli::load_grid({kTool, o.common.quiet}, o.input, o.grid);
    cloud.density = std::move(loaded.grid);
    cloud.report = std::move(loaded.report);
  }
  const Fields fields = load_fields(o);
  for (const formats::LoadedGrid& f : fields.numbers) grids.push_back(&f.grid);
  std::vector<const ColorGrid*> colors;
  for (const formats::LoadedColor& c : fields.colors) colors.push_back(&c.grid);
  std::vector<const VelocityGrid*> velocities;
  for (const formats::LoadedVelocity& v : fields.velocities) velocities.push_back(&v.grid);
  std::vector<std::string> vectors;
  for (const ColorGrid* g : colors) vectors.push_back(g->name());
  for (const VelocityGrid* g : velocities) vectors.push_back(g->along[0].name);
  const bool nothing = cloud.grid().bricks.empty() && cloud.grid().tiles.empty();
  if (nothing && (!fields.numbers.empty() || !vectors.empty())) grids.erase(grids.begin());
  formats::write_vdb(o.output, grids, colors, velocities);
  report(o, cloud.report, grids, vectors);
  return cli::kSuccess;
}

Options options_of_frame(const Options& o, int frame) {
  Options one = o;
  one.input = cli::file_of_frame(o.input, frame);
  one.output = cli::file_of_frame(o.output, frame);
  one.frames.frame = frame;
  return one;
}

int run(const Options& o) {
  cli::check_frames(o.frames);
  if (!o.frames.any()) {
    cli::refuse_pattern(o.input);
    cli::refuse_pattern(o.output);
    return convert(o);
  }
  check_pair(o);
  // A scene of USD has all its frames in one file.
  if (!(imports(o) && is_usd(o))) cli::require_pattern({o.input});
  return cli::for_each_file(
      {kTool, o.common.quiet}, o.frames, o.input, o.output,
      [&](int frame, const std::string&) { return convert(options_of_frame(o, frame)); });
}

int merge_parts(int argc, char** argv) {
  cli::MergeGiven given;
  const auto code = cli::read_merge_line(argc, argv, given);
  return code ? *code : cli::merge(given);
}

int filter(int argc, char** argv) {
  cli::FilterGiven given;
  const auto code = cli::read_filter_line(argc, argv, given);
  return code ? *code : cli::filter_frames(given);
}

int convert_one(int argc, char** argv) {
  Options options;
  const auto code = read_command_line(argc, argv, options);
  return code ? *code : run(options);
}

}  // namespace

int main(int argc, char** argv) {
  cli::watch_signals(kTool);
  return cli::run_guarded(kTool, [&] {
    // Two verbs; for all else the endings of two names decide.
    if (argc > 1 && argv[1] == std::string_view("merge")) return merge_parts(argc - 1, argv + 1);
    if (argc > 1 && argv[1] == std::string_view("denoise")) return filter(argc - 1, argv + 1);
    return convert_one(argc, argv);
  });
}
