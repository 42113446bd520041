#include "stats/trade_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "cli/command_line.h"
#include "cli/split_line.h"

namespace pvol::cli {
namespace {

constexpr const char* kTradeHelp = R"(What is measured:
  Settings of one option each (octree depth, micro-bounds, tracker, shadow rays, guided paths,
  shells, interpolation, precision of the density, homogenised nodes, previews, bounce limit), then
  combinations of those that gained most, each against the default in the same rounds. time: CPU
  time of a sample, on one thread. variance: of a sample, its channels weighted as in luminance,
  averaged over the pixels. time x variance: cost of a picture of given noise. Bias: the mean
  against many samples of the default; the report calls a setting biased if the means of the
  picture's parts or its pixels differ by more than noise explains, and errs once in a hundred
  reports.

  With --denoise, only the filter of pvol-render --denoise is measured, at 4, 16, 64 ... samples per
  pixel as far as the budget allows: its error, its bias, and the time of an unfiltered picture of
  the same error over its own. Pixels of a larger picture have less detail and are filtered better:
  choose the --size of the render.

Examples:
  pvol-stats trade cloud.vdb --budget 120 --html trade.html
      two minutes of measuring, and a page with the results
  pvol-stats trade clouds/*.vdb --for slurm | bash
      all of them on a farm, with reports in NAME.trade.json
  pvol-stats trade scene.toml --max-error 0.02
      the setting that renders the scene with a relative error of 2 % in the least time

Exit status: 0 success, 1 failure, 2 wrong usage.)";

constexpr const char* kDepthHelp = R"(What is measured:
  The effect of the octree's depth, after table 1 of "Rendering of inhomogeneous volumes using
  perturbation functions": building time and tracking time for each depth, in turn, with their
  ratios to the first depth's. bounds: extremes of all voxels down to leaves of 8^3, the same for
  every depth; tree: bricks of samples and the octree. Walks stop where that costs least, and not
  below the depth; "16 = 7" is a depth of 16 where they go no deeper than 7 without a limit.

Examples:
  pvol-stats depth cloud.vdb
      depths 0, 4, 8 and 16 of the cloud at 40 mean free paths
  pvol-stats depth cloud.vdb --tracker delta --thickness 10 --html depth.html
      another tracker, a thinner cloud, and a page with the plots

Exit status: 0 success, 1 failure, 2 wrong usage.)";

/// "96x64" as two whole numbers from 1 to 4096, or nothing.
std::optional<std::array<int, 2>> parse_size(const std::string& text) {
  constexpr int kLargest = 4096;
  std::array<int, 2> size{};
  const char* const end = text.data() + text.size();
  const auto [x, no_width] = std::from_chars(text.data(), end, size[0]);
  if (no_width != std::errc{} || x == end || *x != 'x') return std::nullopt;
  const auto [rest, no_height] = std::from_chars(x + 1, end, size[1]);
  if (no_height != std::errc{} || rest != end) return std::nullopt;
  const bool fits = std::ranges::all_of(size, [](int v) { return v >= 1 && v <= kLargest; });
  return fits ? std::optional(size) : std::nullopt;
}

Check is_size() {
  return {[](const std::string& text) -> std::string {
    if (parse_size(text)) return {};
    return fmt::format("found '{}', expected WxH, whole numbers from 1 to 4096", text);
  }};
}

void add_scene(const CommandLine& verb, SceneOptions& o, StatsArray& array) {
  verb.add_option("FILE", array.clouds,
                  "Scene (.toml), or a cloud: .pvol, .vdb, .nvdb, or a recipe (.toml); with --for "
                  "any number of them")
      .takes_all()
      .type_name("")
      .required();
  verb.add_option("--grid", o.grid.grid,
                  "Grid of a .vdb or .nvdb file [density, else the only one]")
      .type_name("NAME");
  verb.add_option("--set", o.sets, "Set a value of the scene, e.g. medium.g=0.5; repeatable")
      .type_name("KEY=VALUE")
      .repeatable();
  const Option thickness =
      verb.add_option("--thickness", o.thickness,
                      "Mean optical thickness along the cloud's thickest axis; sets the extinction "
                      "[the scene's, else 40]")
          .type_name("X")
          .check(above_zero());
  verb.add_option("--extinction", o.extinction,
                  "Extinction per world unit and unit of density, instead")
      .type_name("X")
      .check(above_zero())
      .excludes(thickness);
  verb.add_option_function(
          "--size", [&o](const std::string& text) { o.size = parse_size(text); },
          "Size of the pictures measured [about 96x96]")
      .type_name("WxH")
      .check(is_size());
  verb.add_flag("--force", o.force, "Measure even settings that would hardly end");
  add_form(verb, array.given,
           "Measure nothing; print a task for each of the files, which writes NAME.VERB.json: "
           "text, lines for bash; json; slurm, a script that submits an array");
}

void add_output(const CommandLine& verb, double& budget, std::optional<std::filesystem::path>& html,
                bool& json, bool& quiet) {
  verb.add_option(
          "--budget", budget,
          fmt::format("Limit of the time for measuring, after loading, in seconds [{}]", budget))
      .type_name("SECONDS")
      .check(number_from(0.1, 1e6, "a number from 0.1 to 1e6"));
  verb.add_flag("--json", json, "Print the report as JSON");
  verb.add_option("--html", html, "Write the report as an HTML page as well").type_name("FILE");
  verb.add_flag("--quiet", quiet,
                "Print no progress and no text, only warnings and errors; files are written");
}

}  // namespace

void add_depth(const CommandLine& app, DepthOptions& o, std::function<int()>& run) {
  const CommandLine verb =
      app.add_verb("depth", "Costs and gains of the octree's depth", kDepthHelp, [&] {
        run = [&] {
          return run_or_print(o.array, "depth", o.html.has_value(), [&](const auto& cloud) {
            o.scene.input = cloud;
            return run_depth(o);
          });
        };
      });
  add_scene(verb, o.scene, o.array);
  std::vector<std::string> trackers;  // but the one that uses no octree
  for (const Named<Tracker>& t : names(Tracker{})) {
    if (t.value != Tracker::delta_global) trackers.emplace_back(t.name);
  }
  verb.add_option("--depths", o.depths,
                  fmt::format("Octree depths, {}, separated by commas; the others are compared "
                              "with the first [0,4,8,16]",
                              ends_of(whole(0, kDeepestOctree))))
      .type_name("N,N,...")
      .separated_by(',')
      .check(fits(whole(0, kDeepestOctree)));
  verb.add_option("--tracker", o.tracker,
                  fmt::format("Tracker of free paths: {} [the scene's, else decomposition]",
                              listed(trackers)))
      .type_name("NAME")
      .check(one_of(trackers));
  verb.add_option("--spp", o.most_samples,
                  "Maximum number of samples per pixel in one round [65536]")
      .type_name("N")
      .check(fits(whole(2, 65536)));
  add_output(verb, o.budget, o.html, o.json, o.quiet);
}

void add_trade(const CommandLine& app, TradeOptions& o, std::function<int()>& run) {
  const CommandLine verb =
      app.add_verb("trade", "Gain in time and cost in error of each option", kTradeHelp, [&] {
        run = [&] {
          return run_or_print(o.array, "trade", o.html.has_value(), [&](const auto& cloud) {
            o.scene.input = cloud;
            return run_trade(o);
          });
        };
      });
  add_scene(verb, o.scene, o.array);
  const Option error =
      verb.add_option("--max-error", o.most_error,
                      "Recommend the fastest setting for this error, the root mean square over the "
                      "mean luminance, e.g. 0.02 [0.1, 0.03 and 0.01]")
          .type_name("X")
          .check(number_from(1e-9, 1e3, "a number from 1e-9 to 1000"));
  const Option time =
      verb.add_option(
              "--max-time", o.most_time,
              "Recommend the setting of least error for this CPU time of the picture, in seconds")
          .type_name("SECONDS")
          .check(number_from(1e-3, 1e9, "a number from 0.001 to 1e9"))
          .excludes(error);
  verb.add_flag("--denoise", o.denoise,
                "Measure gain and error of filtering the picture, instead of the options")
      .excludes(time);
  verb.add_option("--threads", o.threads,
                  "Number of threads for the reference; all other renders are timed on one. 0 is "
                  "one for each hardware thread [0]")
      .type_name("N")
      .check(fits(whole(0, kMostThreads)));
  add_output(verb, o.budget, o.html, o.json, o.quiet);
}

}  // namespace pvol::cli
