#include "cli/render_options.h"

#include "cli/cli_app.h"
#include "pvol/density/quantise.h"
#include "pvol/track/tracker.h"

namespace pvol::cli {
namespace {

constexpr const char* kExamples =
    R"(Without a scene file the camera frames the cloud, under a sun and a gradient sky. Where no extinction
is given, one is chosen that makes the cloud about 40 mean free paths thick, and printed.
World units are those of the cloud's transform; extinction is per world unit and unit of density.

Examples:
  pvol-render cloud.vdb -o cloud.exr --size 1280x720 --spp 256
      writes cloud.exr and cloud.png
  pvol-render scene.toml -o noon.exr --set medium.g=0.5 --tracker delta --stats noon.json
      a scene with one value changed, and the counts of the work done

Ctrl-C saves what was rendered. Exit status: 0 success, 1 failure, 2 wrong usage.)";

/// An option of N whole numbers from `least` up with a separator between them: 640x480.
template <std::size_t N>
CLI::Option* add_numbers(CLI::App& app, const std::string& name,
                         std::optional<std::array<int, N>>& numbers, char separator, int least,
                         const std::string& description) {
  constexpr int kLargest = 1 << 20;  // far above any picture's edge
  const auto read = [&numbers, separator, least](const std::string& text) -> std::string {
    const std::vector<std::string> parts = CLI::detail::split(text, separator);
    std::array<int, N> values{};
    bool good = parts.size() == N;
    for (std::size_t i = 0; good && i < N; ++i) {
      good = CLI::detail::lexical_cast(parts[i], values[i]) && values[i] >= least &&
             values[i] <= kLargest;
    }
    if (good) numbers = values;
    return good ? ""
                : "found '" + text + "', expected whole numbers from " + std::to_string(least) +
                      " to " + std::to_string(kLargest);
  };
  return app
      .add_option_function<std::string>(
          name, [](const std::string&) {}, description)
      ->check(CLI::Validator(read, ""));
}

void add_files(CLI::App& app, RenderOptionsGiven& o) {
  app.add_option("INPUT", o.input,
                 "Scene (.toml), or a cloud: .pvol, .vdb, .nvdb, or a recipe (.toml)")
      ->type_name("")
      ->required();
  app.add_option("-o,--output", o.output,
                 "Picture to write: .exr (linear, with a .png beside it) or .png alone")
      ->type_name("FILE");
  app.add_option("--png", o.png, "Name of the .png [the output's, ending in .png]")
      ->type_name("FILE");
  app.add_flag("--no-png", o.no_png, "Write no .png");
  app.add_option("--exposure", o.exposure, "Exposure of the .png in stops (EV) [0]")
      ->type_name("EV")
      ->check(number_from(-100, 100, "a number from -100 to 100"));
  app.add_option("--stats", o.stats,
                 "Count the work and write counts, times and errors as JSON; - is stdout")
      ->type_name("FILE");
  app.add_option("--grid", o.grid.grid, "Grid of a .vdb or .nvdb file [density, else the only one]")
      ->type_name("NAME");
  app.add_flag("--strict", o.grid.strict, "Refuse a cloud that draws a warning");
}

void add_picture(CLI::App& app, RenderOptionsGiven& o) {
  add_numbers(app, "--size", o.size, 'x', 1, "Size of the image in pixels [640x480]")
      ->type_name("WxH");
  add_numbers(app, "--crop", o.crop, ',', 0, "Part of the image to render, in pixels [all]")
      ->type_name("X,Y,W,H");
  app.add_option("--background", o.background,
                 "Whether the sky is seen behind the cloud; off leaves it transparent [on]")
      ->type_name("on|off")
      ->check(one_of({"on", "off"}));
  app.add_option("--set", o.sets, "Set a value of the scene, e.g. medium.g=0.5; repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_flag("--print-scene", o.print_scene,
               "Print the scene with every value as TOML, and render nothing");
}

void add_estimator(CLI::App& app, RenderOptionsGiven& o) {
  app.add_option("--spp", o.samples, "Samples per pixel [64]")
      ->type_name("N")
      ->check(CLI::Range(1u, 4294967295u).description(""));
  app.add_option("--seed", o.seed, "Seed of the random numbers [1]")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t(0), (std::uint64_t(1) << 63) - 1).description(""));
  app.add_option("--threads", o.threads, "Threads; 0 is one for each hardware thread [0]")
      ->type_name("N")
      ->check(CLI::Range(0, 4096).description(""));
  app.add_option("--tracker", o.tracker,
                 "Free paths: delta-global, delta, decomposition, weighted-delta, "
                 "weighted-decomposition or regular; same picture, other cost [decomposition]")
      ->type_name("NAME")
      ->check(one_of({"delta-global", "delta", "decomposition", "weighted-delta",
                      "weighted-decomposition", "regular"}));
  app.add_option("--transmittance", o.transmittance,
                 "Shadow rays: ratio, analog, residual-ratio or regular; auto chooses by the "
                 "cloud's bounds and says why [auto]")
      ->type_name("NAME")
      ->check(one_of({"auto", "ratio", "analog", "residual-ratio", "regular"}));
  app.add_option("--micro-bounds", o.micro_bounds,
                 "Bounds of cubes of 2^3 or of single voxels that save look-ups; same picture to "
                 "the last bit, auto uses 2^3 where they should save time. Those of 2^3 are taken "
                 "from a .pvol file that has them, else built [auto]")
      ->type_name("auto|none|2|1")
      ->check(one_of({"auto", "none", "2", "1"}));
  app.add_option(
         "--interpolation", o.look_up,
         "Between voxels: nearest, trilinear, or tricubic (B-spline; a .pvol must be fitted "
         "for it); procedural evaluates a recipe without sampling it [trilinear]")
      ->type_name("NAME")
      ->check(one_of({"nearest", "trilinear", "tricubic", "procedural"}));
  app.add_option(
         "--density", o.density,
         "Round the density to fp16, fp8 or fpn, as pvol-fit explains them: a biased picture "
         "that shows what such a file would lose [as stored]")
      ->type_name("NAME")
      ->check(one_of({"fp32", "fp16", "fp8", "fpn"}));
  app.add_option("--density-tolerance", o.density_tolerance,
                 "Largest error of a sample with --density fpn, relative to the largest sample, "
                 "0.00001 to 1 [0.01]")
      ->type_name("X")
      ->check(number_from(kLeastTolerance, kLargestTolerance, "a number from 0.00001 to 1"));
  app.add_option("--depth", o.depth, "Octree depth where the walk stops, 0 to 16 [auto: by cost]")
      ->type_name("N|auto")
      ->check(word_or_number({"auto"}, 16));
  app.add_option(
         "--shells", o.shells,
         "Whether camera rays test the shell of a .pvol file before its octree: the picture "
         "is the same; auto estimates for this camera whether it saves time [auto]")
      ->type_name("auto|on|off")
      ->check(one_of({"auto", "on", "off"}));
  app.add_option("--guide", o.guide,
                 "Whether paths are guided by a coarse estimate of where the light is: less noise "
                 "in thick clouds, same picture on average; auto guides where it should pay [auto]")
      ->type_name("auto|on|off")
      ->check(one_of({"auto", "on", "off"}));
  app.add_option("--max-bounces", o.max_bounces,
                 "Most scatterings of a path; a limit makes the picture too dark [none]")
      ->type_name("N|none")
      ->check(word_or_number({"none"}, 4294967295u));
  app.add_option("--homogenise", o.homogenise,
                 "Biased: nodes that can change the optical depth of a ray by no more than this "
                 "count as homogeneous, without look-ups; the log has a bound on the error of "
                 "whole rays [off]")
      ->type_name("DEPTH")
      ->check(number_from(0, std::numeric_limits<double>::max(), "a number from 0 up"));
  app.add_option("--preview", o.preview,
                 "Biased: halve the number of samples along each axis that many times, 0 to 8 [0]")
      ->type_name("N")
      ->check(CLI::Range(0, 8).description(""));
  app.add_option("--majorant-scale", o.majorant_scale,
                 "For measurements: factor on majorants, 1/3 to 1000. Above 1 the picture stays "
                 "the same; below 1 it takes a weighted tracker and more samples [1]")
      ->type_name("X")
      ->check(number_from(1 / kMostBoundsExcess, 1000, "a number from 1/3 to 1000"));
  app.add_flag("--force", o.force, "Render even where a path would scatter a million times");
}

}  // namespace

std::optional<int> read_command_line(int argc, char** argv, RenderOptionsGiven& o) {
  CLI::App app{"Renders a cloud by unbiased path tracing.", "pvol-render"};
  add_common(app, kExamples);
  add_quiet(app, o.common);
  add_files(app, o);
  add_picture(app, o);
  add_estimator(app, o);
  return parse(app, argc, argv);
}

}  // namespace pvol::cli
