// pvol-stats: measured facts about clouds, and about pictures of them.
#include <functional>

#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "stats/stats.h"
#include "stats/trade_options.h"

namespace {

using namespace pvol;

constexpr const char* kExamples = R"(Examples:
  pvol-stats info cloud.vdb
      its grids, their ranges, where they lie, and which of them a render uses
  pvol-stats bounds cloud.pvol
      nodes, tightness and classes of space, depth by depth, and bytes by part
  pvol-stats bounds cloud.vdb --extinction 0.5 --json
      the same as JSON, and the renderer's choices at 0.5 per world unit
  pvol-stats shells cloud.pvol --verify
      how tight the shell is, and a new proof that it contains the cloud
  pvol-stats image fast.exr reference.exr --html compare.html
      whether the pictures differ by more than noise, and where

Exit status: 0 success, 1 failure, 2 wrong usage.)";

constexpr const char* kBoundsHelp = R"(What the figures mean:
  Mass is the integral of the density. hi and lo are the largest and smallest density that the
  bounds of a cube allow. hi/mean and lo/mean: the bound over the cube's own mean density, averaged
  with equal weights for all cubes of a depth; 1 would be perfect. Weighted by mass, the average of
  hi/mean is the column even.
  Look-ups per collision: tentative collisions of delta tracking come at the rate hi, those that
  decomposition has to look up at the rate hi - lo, real ones at the rate of the density. The
  average depends on how often paths visit a place, so there are two figures. even: collisions are
  distributed like the density (integral of hi, or of hi - lo, over the mass), as in thin clouds.
  dense: places are weighted by their leaf's mean density once more, as where paths stay in the
  core. In a thick cloud seen from outside, paths stay at the rim and the figures of a render are
  higher: see pvol-render --stats.)";

constexpr const char* kShellsHelp = R"(What the figures mean:
  Volume: of the shell over that of all voxels in which the interpolated density can be above 0.
  Rays: of all straight lines, uniform in direction and place, those that hit the shell over those
  that hit such a voxel; a renderer follows the excess rays in vain.
  Slack: how far inside the shell the cloud lies, in units of the shell's own function; any
  certified bound above the rounding errors of ray tests proves that no ray through the cloud is
  lost.)";

constexpr const char* kImageHelp = R"(What the figures mean:
  Noise is the variance of each pixel's mean, from its own samples (layers variance and samples of
  pvol-render); the pictures must be independent (different seeds). Bias: the mean difference, with
  its confidence interval. Systematic MSE: the MSE minus the part that noise explains, an unbiased
  estimate that may fall below 0. The verdict tests the means of the picture, of its quarters, of
  their quarters and so on, and the systematic MSE, in every channel; --level is for all of these
  together.)";

constexpr const char* kInfoHelp = R"(What the figures mean:
  Use: what a render takes the grid for where the scene says nothing, by the names that simulators
  write. Values: the least and the largest above 0. Voxels: the first and last lattice points with
  such values. World: the box of the interpolated values, one voxel wider. Voxel: the lengths of
  its edges in the world; "turned" where its axes are not the world's. Memory: of the samples.)";

struct Options {
  cli::InfoOptions info;
  cli::BoundsOptions bounds;
  cli::ShellsOptions shells;
  cli::ImageOptions image;
  cli::DepthOptions depth;
  cli::TradeOptions trade;
  std::function<int()> run;  ///< the verb that was given
};

void add_info(const cli::CommandLine& app, Options& o) {
  const cli::CommandLine verb =
      app.add_verb("info", "The grids of files, where they lie, and what a render uses",
                   std::string(kInfoHelp) + "\n\n" + kExamples,
                   [&o] { o.run = [&o] { return cli::run_info(o.info); }; });
  verb.add_option("FILE", o.info.inputs, "Clouds: .pvol, .vdb, .nvdb, or recipes (.toml)")
      .takes_all()
      .type_name("")
      .required();
  verb.add_flag("--json", o.info.json, "Print the report as JSON");
}

void add_bounds(const cli::CommandLine& app, Options& all) {
  cli::BoundsOptions& o = all.bounds;
  const cli::CommandLine verb =
      app.add_verb("bounds", "How tight the bounds of a cloud are",
                   std::string(kBoundsHelp) + "\n\n" + kExamples,
                   [&all] { all.run = [&all] { return cli::run_bounds(all.bounds); }; });
  verb.add_option("FILE", o.input, "Cloud: .pvol, .vdb, .nvdb, or a recipe (.toml)")
      .type_name("")
      .required();
  verb.add_option("--extinction", o.extinction,
                  "Extinction per world unit and unit of density: adds free path, optical "
                  "thickness, and the cut that the renderer's cost model chooses")
      .type_name("X")
      .check(cli::above_zero());
  verb.add_option("--grid", o.grid.grid,
                  "Grid of a .vdb or .nvdb file [density, else the only float grid]")
      .type_name("NAME");
  verb.add_flag("--strict", o.grid.strict, "Refuse an input that causes a warning");
  verb.add_flag("--measure", o.measure,
                "Render a small picture and count the cost of collisions; without --extinction, "
                "the cloud is 10 optical depths thick on average");
  verb.add_flag("--verify", o.verify,
                "Compare every bound with every sample on which it depends, and list the bounds "
                "that do not hold; one such bound is an error");
  verb.add_option("--html", o.html,
                  "Write a page with plots, slices and maps of look-ups; implies --measure")
      .type_name("FILE");
  verb.add_flag("--json", o.json, "Print the report as JSON");
}

void add_shells(const cli::CommandLine& app, Options& o) {
  const cli::CommandLine verb =
      app.add_verb("shells", "How tight a cloud's shell is, and whether it contains the cloud",
                   std::string(kShellsHelp) + "\n\n" + kExamples,
                   [&o] { o.run = [&o] { return cli::run_shells(o.shells); }; });
  verb.add_option("FILE", o.shells.input, "Cloud: a .pvol file with a shell")
      .type_name("")
      .required();
  verb.add_flag("--verify", o.shells.verify,
                "Prove again, from the density, that the shell contains every occupied voxel, and "
                "measure it again; failure is an error");
  verb.add_flag("--check", o.shells.check,
                "Check the shell with CGAL in exact arithmetic, and report distances");
  verb.add_option(
          "--html", o.shells.html,
          "Write a page with slices, and with the cost and savings of the shell in a render")
      .type_name("FILE");
  verb.add_flag("--json", o.shells.json, "Print the report as JSON");
}

void add_image(const cli::CommandLine& app, Options& all) {
  cli::ImageOptions& o = all.image;
  const cli::CommandLine verb =
      app.add_verb("image", "How far two pictures differ beyond their noise",
                   std::string(kImageHelp) + "\n\n" + kExamples,
                   [&all] { all.run = [&all] { return cli::run_image(all.image); }; });
  verb.add_option("A", o.a, "Picture to test (.exr)").type_name("").required();
  verb.add_option("B", o.b, "Picture of the same view to compare it with (.exr)")
      .type_name("")
      .required();
  verb.add_option("--confidence", o.confidence, "Confidence level of the intervals [0.95]")
      .type_name("P")
      .check(cli::number_from(0, 0.999999, "a number from 0 to 0.999999"));
  verb.add_option("--level", o.level, "Probability of reporting a bias where there is none [0.001]")
      .type_name("P")
      .check(cli::number_from(1e-12, 0.5, "a number from 1e-12 to 0.5"));
  verb.add_option("--html", o.html, "Write a page with both pictures and maps of the difference")
      .type_name("FILE");
  verb.add_option("--map", o.map, "Write the difference: .exr as numbers, .png in colours")
      .type_name("FILE");
  verb.add_flag("--fail-on-bias", o.fail_on_bias, "Exit with status 1 where a bias is detected");
  verb.add_flag("--json", o.json, "Print the report as JSON");
}

std::optional<int> read_command_line(int argc, char** argv, Options& o) {
  const cli::CommandLine app(
      "Measures clouds, their bounds and their shells, and compares pictures of them.",
      "pvol-stats", kExamples);
  add_info(app, o);
  add_bounds(app, o);
  add_shells(app, o);
  add_image(app, o);
  cli::add_depth(app, o.depth, o.run);
  cli::add_trade(app, o.trade, o.run);
  o.depth.array.arguments.assign(argv, argv + argc);
  o.trade.array.arguments = o.depth.array.arguments;
  return app.parse(argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  cli::watch_signals("pvol-stats");
  return cli::run_guarded("pvol-stats", [&] {
    Options options;
    const auto code = read_command_line(argc, argv, options);
    return code ? *code : options.run();
  });
}
