// pvol-stats: measured facts about a cloud.
#include "cli_app.h"
#include "stats.h"

namespace {

using namespace pvol;

constexpr const char* kExamples = R"(Examples:
  pvol-stats bounds cloud.pvol
      nodes, tightness and classes of space, depth by depth, and bytes by part
  pvol-stats bounds cloud.vdb --extinction 0.5 --json
      the same as JSON, and what the renderer would choose at 0.5 per world unit
  pvol-stats shells cloud.pvol --verify
      how tight the shell is; proves again that it holds the cloud

Exit status: 0 success, 1 failure, 2 wrong usage.)";

constexpr const char* kBoundsHelp = R"(What the figures mean:
  Mass is the integral of the density. hi and lo are the largest and smallest density that the
  bounds of a cube allow. hi/mean and lo/mean: the bound over the cube's own mean density, averaged
  with every cube of a depth counting alike; 1 would be perfect. With cubes counting by their mass
  the average of hi/mean is the column even.
  Look-ups per collision: tentative collisions of delta tracking come at the rate hi, those that
  decomposition has to look up at the rate hi - lo, real ones at the density's. How often paths visit
  a place decides which places count, so there are two figures. even: collisions lie as the density
  does (integral of hi, or of hi - lo, over the mass), as in clouds thin enough to see through.
  dense: places count by their leaf's mean density once more, as where paths stay in the core. In a
  thick cloud seen from outside, paths stay at the rim and the figures of a render are higher: see
  pvol-render --stats.)";

constexpr const char* kShellsHelp = R"(What the figures mean:
  Volume: of the shell over that of all voxels in which the interpolated density can be above 0.
  Rays: of all straight lines, even in direction and place, those that meet the shell over those that
  meet such a voxel; the excess are rays that a renderer follows for nothing.
  Slack: how far inside the shell the cloud lies, in units of the shell's own function; any certified
  bound above the rounding errors of ray tests proves that no ray through the cloud is lost.)";

struct Options {
  cli::BoundsOptions bounds;
  cli::ShellsOptions shells;
  bool is_shells = false;
};

void add_bounds(CLI::App& app, cli::BoundsOptions& o) {
  CLI::App* verb = app.add_subcommand("bounds", "How tight the bounds of a cloud are");
  cli::add_common(*verb, std::string(kBoundsHelp) + "\n\n" + kExamples);
  verb->add_option("FILE", o.input, "The cloud: .pvol, .vdb, .nvdb, or a recipe (.toml)")
      ->type_name("")
      ->required();
  verb->add_option("--extinction", o.extinction,
                   "Extinction per world unit and unit of density: adds free path, optical "
                   "thickness, and the cut that the renderer's cost model chooses")
      ->type_name("X")
      ->check(CLI::PositiveNumber.description(""));
  verb->add_option("--grid", o.grid.grid,
                   "Grid of a .vdb or .nvdb file [density, else the only float grid]")
      ->type_name("NAME");
  verb->add_flag("--strict", o.grid.strict, "Refuse an input that draws a warning");
  verb->add_flag("--json", o.json, "The report as JSON");
}

void add_shells(CLI::App& app, Options& o) {
  CLI::App* verb = app.add_subcommand("shells", "How tight a cloud's shell is, and that it holds");
  cli::add_common(*verb, std::string(kShellsHelp) + "\n\n" + kExamples);
  verb->add_option("FILE", o.shells.input, "The cloud: a .pvol file with a shell")
      ->type_name("")
      ->required();
  verb->add_flag("--verify", o.shells.verify,
                 "Prove again, from the density, that the shell holds every occupied voxel, and "
                 "measure it again; a shell that does not is an error");
  verb->add_flag("--check", o.shells.check,
                 "Check the shell with CGAL in exact arithmetic, and report distances");
  verb->add_flag("--json", o.shells.json, "The report as JSON");
  verb->callback([&o] { o.is_shells = true; });
}

std::optional<int> read_command_line(int argc, char** argv, Options& o) {
  CLI::App app{"Measures clouds, their bounds and their shells.", "pvol-stats"};
  cli::add_common(app, kExamples);
  app.require_subcommand(1);
  add_bounds(app, o.bounds);
  add_shells(app, o);
  return cli::parse(app, argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const auto code = read_command_line(argc, argv, options)) return *code;
  return cli::run_guarded("pvol-stats", [&] {
    return options.is_shells ? cli::run_shells(options.shells) : cli::run_bounds(options.bounds);
  });
}
