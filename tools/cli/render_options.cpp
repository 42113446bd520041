#include "cli/render_options.h"

#include <fmt/format.h>

#include <array>

#include "cli/command_line.h"
#include "cli/frames_line.h"
#include "cli/picture_line.h"
#include "cli/scene_line.h"
#include "cli/split_line.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {
namespace {

constexpr const char* kExamples =
    R"(Without a scene file, the camera frames the cloud under a sun and a gradient sky. If no extinction
is set, one that makes the cloud about 40 mean free paths thick is chosen and printed.
World units are those of the cloud's transform; extinction is per world unit and unit of density.

Examples:
  pvol-render cloud.vdb -o cloud.exr --size 1280x720 --spp 256
      writes cloud.exr and cloud.png
  pvol-render cloud.vdb -o cloud.exr --background off --aov variance,samples --pixel-type half
      a cloud to composite over another picture, with the layers that pvol-stats image needs
  pvol-render scene.toml -o noon.exr --set medium.g=0.5 --tracker delta --stats noon.json
      a scene with one value changed, and counts of the work in a file
  pvol-render smoke.####.pvol -o smoke.####.exr --frames 1-240
      a sequence: extinction and camera are those of frame 1, and each frame has different noise;
      when run again, it skips finished frames
  pvol-render scene.toml -o scene.exr --spp 65536 --resume
      a long render: run it again to continue after Ctrl-C, a killed process or a full disk

Ctrl-C and SIGTERM save the picture so far, and a second one ends at once; SIGUSR1 writes a
checkpoint.
Exit status: 0 success, 1 failure, 2 wrong usage.)";

/// How the picture is written, which says nothing of what is in it.
void add_layout(const CommandLine& app, RenderOptionsGiven& o) {
  add_named(app, "--pixel-type", o.pixels,
            "Type of colours in the .exr: float, or half, which needs half the bytes, rounds to 11 "
            "bits and ends at 65504; numbers such as variance are always float [float]");
  add_named(app, "--compression", o.compression,
            "Compression of the .exr: zip, zips, piz, none, or dwaa, which rounds colours [zip]");
  app.add_flag(
      "--multipart", o.multipart,
      "Write each layer of --aov to a separate part of the .exr instead of channels of one part");
}

void set_resume(RenderOptionsGiven& o, bool resume) {
  if (o.resume && *o.resume != resume) {
    throw UsageError("--resume and --no-resume exclude each other");
  }
  o.resume = resume;
}

void add_files(const CommandLine& app, RenderOptionsGiven& o) {
  app.add_option("INPUT", o.input,
                 "Scene (.toml), or a cloud: .pvol, .vdb, .nvdb, or a recipe (.toml)")
      .type_name("")
      .required();
  app.add_option("-o,--output", o.output,
                 "Picture to write: .exr (linear, with a .png beside it) or .png alone")
      .type_name("FILE");
  app.add_option("--png", o.png, "Name of the .png [the output's, ending in .png]")
      .type_name("FILE");
  app.add_flag("--no-png", o.no_png, "Write no .png");
  add_display(app, o.display);
  app.add_flag(
      "--denoise", o.denoise,
      "Biased: filter the noise of the finished picture, guided by features of first collisions. "
      "The .exr keeps the noisy picture and its variance as layers noisy and noisy_variance; the "
      "log and the layer variance give the estimated error, bias included");
  app.add_flag("--denoise-layers", o.denoise_layers,
               "Write the layers that pvol-convert denoise needs to filter the picture afterwards, "
               "or a sequence with light from frame to frame");
  app.add_option("--checkpoint", o.checkpoint,
                 "Minutes between checkpoints, which write the outputs so far; --resume continues "
                 "from them if the render ends early; 0 is none [10]")
      .type_name("MINUTES")
      .check(number_from(0, 1e6, "minutes from 0 to a million"));
  app.add_flag_callback(
      "--resume", [&o] { set_resume(o, true); },
      "Continue the unfinished picture at --output, if it shows this scene; the result has the "
      "bytes of an uninterrupted render. If the picture is finished, do nothing. Frames of a "
      "sequence are always resumed");
  app.add_flag_callback(
      "--no-resume", [&o] { set_resume(o, false); },
      "Render everything again, including finished frames of a sequence");
  app.add_option("--pilot", o.pilot,
                 "With --noise: a whole, merged picture of --samples 0:16, from which this part "
                 "takes its first samples and the distribution of the others")
      .type_name("FILE");
  add_named(app, "--sums", o.sums,
            "Whether the .exr keeps exact sums, for --resume and pvol-convert merge; auto: if it "
            "is a part or unfinished [auto]");
  app.add_flag("--live", o.live,
               "Write the .png while rendering, at most once per second, and beside it an .html "
               "page of the same name, which a browser reloads until the end");
  app.add_option("--deep", o.deep,
                 "Write a deep .exr as well, with colour and alpha by depth, for compositing with "
                 "other deep pictures; it never has a background")
      .type_name("FILE");
  app.add_option("--stats", o.stats,
                 "Count the work and write counts, times and errors as JSON; - is stdout")
      .type_name("FILE");
  app.add_option("--summary", o.summary,
                 "Write the outcome of each frame of a sequence as JSON: state, times, noise")
      .type_name("FILE");
  app.add_option("--grid", o.grid.grid, "Grid of a .vdb or .nvdb file [density, else the only one]")
      .type_name("NAME");
  app.add_flag("--strict", o.grid.strict, "Refuse a cloud that causes a warning");
}

/// Azimuth and elevation of a camera that frames the clouds, as --view gives them: by a word, or in
/// degrees. Nothing for another text.
std::optional<std::array<std::string, 2>> parse_view(const std::string& view) {
  struct Named {
    const char *name, *azimuth, *elevation;
  };
  constexpr Named kViews[] = {{"front", "0", "0"},   {"right", "90", "0"}, {"side", "90", "0"},
                              {"back", "180", "0"},  {"left", "-90", "0"}, {"top", "0", "90"},
                              {"bottom", "0", "-90"}};
  for (const Named& v : kViews) {
    if (view == v.name) return {{v.azimuth, v.elevation}};
  }
  const std::size_t comma = view.find(',');
  if (comma == std::string::npos) return std::nullopt;
  return {{view.substr(0, comma), view.substr(comma + 1)}};
}

Check is_view(const Entries& camera) {
  return {[azimuth = fits(find_key(camera, "azimuth")->about.limits),
           elevation = fits(find_key(camera, "elevation")->about.limits)](const std::string& text) {
            const auto view = parse_view(text);
            if (!view) {
              return fmt::format(
                  "found '{}', expected front, right, side, back, left, top, bottom, or degrees "
                  "about up and above, such as 45,20",
                  text);
            }
            const std::string fault = azimuth.fault((*view)[0]);
            return fault.empty() ? elevation.fault((*view)[1]) : fault;
          },
          "front right side back left top bottom"};
}

/// What flags add to `sets`, and the flag as it was given.
using FlagSets = std::vector<std::pair<std::string, std::string>>;

/// Flags for a camera that frames the clouds. They add keys of the scene to `sets`.
void add_view(const CommandLine& app, FlagSets& sets) {
  Camera defaults;
  const Entries all = entries(defaults);
  app.add_option_function(
         "--view",
         [&sets](const std::string& text) {
           const auto [azimuth, elevation] = parse_view(text).value();
           sets.emplace_back("camera.azimuth=" + azimuth, "--view " + text);
           sets.emplace_back("camera.elevation=" + elevation, "--view " + text);
         },
         "Direction from which the camera that frames the clouds looks: front, right, side, back, "
         "left, top, bottom, or degrees about up from the front and above, such as 45,20 [a little "
         "above the front]")
      .type_name("NAME|AZ,EL")
      .check(is_view(all));
  for (const char* key : {"zoom", "fov"}) {
    const Entry& e = *find_key(all, key);
    app.add_option_function(
           flag_of(e.about),
           [&sets, key](const std::string& text) {
             sets.emplace_back(fmt::format("camera.{}={}", key, text),
                               fmt::format("--{} {}", key, text));
           },
           help_of(e))
        .type_name(metavar_of(e.about))
        .check(fits(e.about.limits));
  }
  const Limits up = find_key(all, "up")->about.limits;
  app.add_option_function(
         "--up",
         [&sets](const std::string& text) {
           const bool axis = text == "y" || text == "z";
           sets.emplace_back(axis ? "world.up=\"" + text + '"' : "camera.up=[" + text + ']',
                             "--up " + text);
         },
         "Axis that is up, y or z, for camera, sky and the default sun; or, for the camera alone, "
         "any direction [y]")
      .type_name("y|z|X,Y,Z")
      .check({[up](const std::string& text) {
        const auto refusal = refuse(up, parse_value(up, text));
        if (text == "y" || text == "z" || !refusal) return std::string();
        return fmt::format("found '{}', expected y, z or {}", text, command_expected(up, *refusal));
      }});
}

void add_scene(const CommandLine& app, RenderOptionsGiven& o) {
  app.add_option("--set", o.sets,
                 "Set a value of the scene, e.g. medium.g=0.5, or in lists volume[2].medium.g=0.5; "
                 "repeatable")
      .type_name("KEY=VALUE")
      .repeatable();
  app.add_flag("--print-scene", o.print_scene,
               "Print the scene with all its values as TOML, and render nothing");
  app.add_flag("--force", o.force, "Render even scenes that would hardly end");
}

}  // namespace

std::optional<int> read_command_line(int argc, char** argv, RenderOptionsGiven& o) {
  const CommandLine app("Renders a cloud by unbiased path tracing.", "pvol-render", kExamples);
  add_quiet(app, o.common);
  add_files(app, o);
  add_frames(app, o.frames);
  add_lock_frame(app, o.frames);
  add_layout(app, o);
  o.arguments.assign(argv, argv + argc);
  add_split(app, o.split, o.local_copies);
  add_scene_options(app, o.options);
  FlagSets of_flags;
  add_view(app, of_flags);
  add_scene(app, o);
  const std::optional<int> code = app.parse(argc, argv, scene_manual());
  // After all --set, in whose list the parser keeps nothing else.
  for (const auto& [set, flag] : of_flags) {
    o.sets.push_back(set);
    o.flags_of_sets.emplace(set, flag);
  }
  return code;
}

}  // namespace pvol::cli
