#include "cli/render_options.h"

#include "cli/command_line.h"
#include "cli/frames_line.h"
#include "cli/picture_line.h"
#include "cli/scene_line.h"
#include "cli/split_line.h"
#include "cli/view_line.h"
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
  add_to(o.sets, o.flags_of_sets, of_flags);
  return code;
}

}  // namespace pvol::cli
