// pvol-view: a scene, or a cloud alone, in a browser, where its picture refines while it is
// changed.
#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/cli.h"
#include "cli/command_line.h"
#include "cli/frames.h"
#include "cli/frames_line.h"
#include "cli/interrupt.h"
#include "cli/live_scene.h"
#include "cli/scene_files.h"
#include "cli/scene_line.h"
#include "pvol/error.h"
#include "pvol/formats/recipe_file.h"
#include "view/edited_scene.h"
#include "view/server.h"
#include "view/viewer.h"

namespace {

using namespace pvol;
namespace fs = std::filesystem;

constexpr const char* kTool = "pvol-view";

constexpr const char* kExamples =
    R"(The tool prints an address to open in a browser on this machine; Ctrl-C ends it. Whoever does not know
the address sees nothing, and scenes are saved in one folder only.

Examples:
  pvol-view cloud.vdb
      a cloud under a sun, to be lit, framed and saved as a scene
  pvol-view scene.toml --size 1280x720
      a scene, in another size
  pvol-view smoke.####.vdb --frames 1-240
      a sequence, with a slider for its frames
  ssh -L 8080:localhost:8080 farm pvol-view scene.toml --port 8080
      on another machine, with the browser here

Exit status: 0 success, 1 failure, 2 wrong usage.)";

struct Options {
  cli::Common common;
  fs::path input, folder;
  std::string grid;
  std::vector<std::string> sets;
  std::map<std::string, std::string> options;
  std::vector<int> frames;
  int port = 0;
};

std::optional<int> read_command_line(int argc, char** argv, Options& o) {
  const cli::CommandLine app(
      "Shows a scene in a browser, where its picture refines while it is changed.", kTool,
      kExamples);
  add_quiet(app, o.common);
  app.add_option("INPUT", o.input,
                 "Scene (.toml), or a cloud: .pvol, .vdb, .nvdb, or a recipe (.toml)")
      .type_name("")
      .required();
  app.add_option("--port", o.port, "Port to serve on; 0 is one that is free [0]")
      .type_name("N")
      .check(cli::fits(whole(0, 65535)));
  app.add_option("--folder", o.folder, "Folder in which scenes are saved [the input's]")
      .type_name("FOLDER");
  app.add_option_function(
         "--frames", [&o](const std::string& text) { o.frames = cli::parse_frames(text); },
         "Frames of a sequence: 1-240, every tenth 1-240x10, or a list with commas. File names "
         "contain #### or %04d in place of the number")
      .type_name("A-B[xN]")
      .check(cli::parses(cli::parse_frames));
  app.add_option("--grid", o.grid, "Grid of a .vdb or .nvdb file [density, else the only one]")
      .type_name("NAME");
  add_scene_options(app, o.options);
  app.add_option("--set", o.sets, "Set a value of the scene, e.g. medium.g=0.5; repeatable")
      .type_name("KEY=VALUE")
      .repeatable();
  return app.parse(argc, argv, cli::scene_manual());
}

/// The scene with its patterns, and the frames that they stand for.
viewer::EditedScene read_scene(const Options& o) {
  const bool by_frame = !o.frames.empty();
  const fs::path input = o.input;
  formats::SceneFile scene = cli::read_scene(
      by_frame ? cli::file_of_frame(input, o.frames.front()) : input, o.sets, o.grid);
  cli::apply(o.options, formats::render_keys(scene));
  if (by_frame && cli::has_pattern(input)) scene.volumes.front().file = input;
  return {std::move(scene), o.frames};
}

void check_patterns(const Options& o, const viewer::EditedScene& scene) {
  const std::vector<fs::path> files = cli::files_of(scene.scene());
  const bool any = std::ranges::any_of(files, cli::has_pattern);
  if (o.frames.empty() && any) {
    throw cli::UsageError(
        "a file's name has a place for the number of a frame; choose frames with "
        "--frames A-B");
  }
  if (!o.frames.empty() && !any) {
    throw cli::UsageError("--frames needs a file whose name contains #### or %04d");
  }
}

/// Where scenes are saved at first: under the name of the scene, or one like the cloud's.
std::string name_to_save(const fs::path& input) {
  if (formats::ending(input) == ".toml" && !formats::is_recipe(input)) return input.filename();
  std::string name = input.stem().string();
  std::erase(name, '#');
  while (!name.empty() && name.back() == '.') name.pop_back();
  return (name.empty() ? "scene" : name) + "_scene.toml";
}

fs::path folder_to_save(const Options& o) {
  fs::path folder = o.folder.empty() ? o.input.parent_path() : o.folder;
  if (folder.empty()) folder = ".";
  if (!fs::is_directory(folder)) {
    throw cli::UsageError(fmt::format("--folder: {} is no folder", folder.string()));
  }
  return fs::canonical(folder);
}

int run(const Options& o) {
  const fs::path folder = folder_to_save(o);
  viewer::EditedScene given = read_scene(o);
  check_patterns(o, given);
  cli::LiveScene live({kTool, o.common.quiet});
  // What the scene leaves open is chosen now, for all frames and changes.
  const cli::RenderJob job = live.prepare(given.scene_of_frame());
  formats::SceneFile scene = job.file;
  for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
    const formats::SceneVolume& asked = given.scene().volumes[i];
    scene.volumes[i].file = asked.file;
    if (asked.velocity) scene.volumes[i].velocity = asked.velocity;
  }
  scene.scene.environment = given.scene().scene.environment;
  scene.scene.surfaces = given.scene().scene.surfaces;
  viewer::Viewer shown({std::move(scene), o.frames}, std::move(live), folder,
                       name_to_save(o.input));
  viewer::serve(shown, o.port, [&](const std::string& address) {
    std::cout << address << std::endl;
    if (!o.common.quiet) {
      std::cerr << kTool << ": open this address in a browser on this machine; Ctrl-C ends it\n";
    }
  });
  return cli::kSuccess;
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
