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
#include "cli/scene_line.h"
#include "cli/view_line.h"
#include "pvol/error.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_files.h"
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
  ssh -t -L 8080:localhost:8080 farm pvol-view scene.toml --port 8080
      on another machine, with the browser here

Exit status: 0 success, 1 failure, 2 wrong usage.)";

struct Options {
  cli::Common common;
  fs::path input, folder;
  std::string grid;
  std::vector<std::string> sets;
  std::map<std::string, std::string> flags_of_sets;  ///< of those that --view and the like add
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
         "contain ####, %04d or $F4 in place of the number")
      .type_name("A-B[xN]")
      .check(cli::parses(cli::parse_frames));
  app.add_option("--grid", o.grid, "Grid of a .vdb or .nvdb file [density, else the only one]")
      .type_name("NAME");
  add_scene_options(app, o.options);
  cli::FlagSets of_flags;
  cli::add_view(app, of_flags);
  app.add_option("--set", o.sets, "Set a value of the scene, e.g. medium.g=0.5; repeatable")
      .type_name("KEY=VALUE")
      .repeatable();
  const std::optional<int> code = app.parse(argc, argv, cli::scene_manual());
  cli::add_to(o.sets, o.flags_of_sets, of_flags);
  return code;
}

/// Of a sequence the file of the first frame.
fs::path first_input(const Options& o) {
  return o.frames.empty() ? o.input : cli::file_of_frame(o.input, o.frames.front());
}

bool is_scene(const fs::path& file) {
  return formats::ending(file) == ".toml" && !formats::is_recipe(file);
}

/// The scene with its patterns, and the frames that they stand for.
viewer::EditedScene read_scene(const Options& o) {
  const fs::path first = first_input(o);
  if (first != o.input && is_scene(first)) {
    throw cli::UsageError(
        "a scene for each frame cannot be viewed; give one scene whose clouds have names for each "
        "frame, such as smoke.####.vdb");
  }
  formats::SceneFile scene = cli::read_scene_as_set(first, o.sets, o.flags_of_sets, o.grid);
  cli::apply_options(o.options, scene);
  if (first != o.input) scene.volumes.front().file = o.input;
  return {std::move(scene), o.frames};
}

void check_patterns(const Options& o, const viewer::EditedScene& scene) {
  const std::vector<fs::path> files = formats::files_of(scene.scene());
  const bool any = std::ranges::any_of(files, cli::has_pattern);
  if (o.frames.empty() && any) {
    throw cli::UsageError(
        "a file's name has a place for the number of a frame; choose frames with "
        "--frames A-B");
  }
  if (!o.frames.empty() && !any) {
    throw cli::UsageError("--frames needs a file whose name contains ####, %04d or $F4");
  }
}

/// Where scenes are saved at first: under the name of the scene, or one like the cloud's, without
/// the number of a frame.
std::string name_to_save(const Options& o) {
  const fs::path first = first_input(o);
  if (is_scene(first)) return first.filename();
  std::string name = first.stem().string();
  if (first != o.input) name.erase(name.find_last_not_of("0123456789-_.") + 1);
  return (name.empty() ? "scene" : name) + "_scene.toml";
}

fs::path folder_to_save(const Options& o) {
  if (!o.folder.empty() && !fs::is_directory(o.folder)) {
    throw cli::UsageError(fmt::format("--folder: {} is no folder", o.folder.string()));
  }
  if (!o.folder.empty()) return fs::canonical(o.folder);
  const fs::path folder = o.input.parent_path().empty() ? "." : o.input.parent_path();
  if (fs::is_directory(folder)) return fs::canonical(folder);
  throw Error(
      fmt::format("cannot open {}: there is no folder {}", o.input.string(), folder.string()));
}

/// What is empty leaves nothing to choose an extinction or a camera by.
void require_density(const Options& o, const cli::RenderJob& job) {
  const auto is_open = [](const formats::SceneVolume& v) {
    return !v.has_extinction && v.grid != formats::kNoGrid;
  };
  if (o.frames.empty() || std::ranges::none_of(job.file.volumes, is_open)) return;
  throw Error(
      fmt::format("frame {}: the density is 0 everywhere, so extinction and camera cannot be "
                  "chosen; begin with another frame, such as --frames N,{}",
                  o.frames.front(), o.frames.front()));
}

int run(const Options& o) {
  const fs::path folder = folder_to_save(o);
  viewer::EditedScene given = read_scene(o);
  check_patterns(o, given);
  cli::LiveScene live({kTool, o.common.quiet});
  // What the scene leaves open is chosen now, for all frames and changes.
  const cli::RenderJob job = live.prepare(given.scene_of_frame());
  require_density(o, job);
  formats::SceneFile scene = job.file;
  for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
    const formats::SceneVolume& asked = given.scene().volumes[i];
    scene.volumes[i].file = asked.file;
    if (asked.velocity) scene.volumes[i].velocity = asked.velocity;
  }
  scene.scene.environment = given.scene().scene.environment;
  scene.scene.surfaces = given.scene().scene.surfaces;
  viewer::Viewer shown({std::move(scene), o.frames}, std::move(live), folder, name_to_save(o));
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
