// The verb `depth`: what the octree's depth costs and gains on the user's own cloud.
#include <algorithm>
#include <iostream>

#include "cli/cli.h"
#include "cli/instructions.h"
#include "cli/load_scene.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/field/procedural.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/estimators.h"
#include "stats/depth_report.h"
#include "stats/stats_trade.h"
#include "stats/sweep.h"

namespace pvol::cli {
namespace {

constexpr double kReferencePart = 0.2, kBuildPart = 0.2;
constexpr int kBuildRounds = 6, kFewestBuildRounds = 2, kPixels = 96 * 96;

int deepest(const LoadedScene& loaded) {
  int depth = 0;
  for (const formats::Cloud& c : loaded.clouds) {
    depth = std::max(depth, int(c.pyramid.levels.size()) - 1);
  }
  return depth;
}

/// What `auto` would choose by the depth is chosen once, at the deepest, so that only the depth
/// changes.
void fix_choices(const DepthOptions& o, LoadedScene& loaded) {
  RenderOptions& r = loaded.file.scene.options;
  if (o.tracker) r.tracker = find_named<Tracker>(*o.tracker).value();
  if (r.tracker == Tracker::delta_global) {
    throw UsageError("the tracker delta-global uses no octree; choose another one");
  }
  if (r.micro_bounds == MicroBoundsUse::automatic) r.micro_bounds = MicroBoundsUse::none;
  if (r.guide == GuideUse::automatic) r.guide = GuideUse::off;  // it is tracking that is measured
  if (r.transmittance != Transmittance::automatic) return;
  Scene scene = loaded.file.scene;
  scene.options.depth = deepest(loaded);
  const Volume volume =
      make_volume(loaded.clouds.front(), loaded.file.volumes.front(), scene.options);
  r.transmittance = choose_transmittance(std::span(&volume, 1)).estimator;
}

/// Builds bounds and trees of all clouds for each depth, in turn.
std::vector<BuildTimes> time_building(const LoadedScene& loaded, const std::vector<int>& depths,
                                      double end) {
  std::vector<BuildTimes> times(depths.size());
  std::vector<formats::Cloud> clouds = loaded.clouds;
  for (int round = 0; round < kBuildRounds && !interrupted(); ++round) {
    if (round >= kFewestBuildRounds && clock_seconds() > end) break;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      Scene scene = loaded.file.scene;
      scene.options.depth = depths[i];
      double bounds = 0, tree = 0;
      for (std::size_t k = 0; k < clouds.size(); ++k) {
        formats::Cloud& c = clouds[k];
        const double begin = cpu_seconds();
        c.pyramid =
            c.recipe() ? build_pyramid(*c.recipe()) : build_pyramid(c.grid(), c.pyramid.look_up);
        const double middle = cpu_seconds();
        const Volume volume = make_volume(c, loaded.file.volumes[k], scene.options);
        bounds += middle - begin, tree += cpu_seconds() - middle;
      }
      times[i].bounds.push_back(bounds), times[i].tree.push_back(tree);
    }
  }
  return times;
}

/// Depths at which walks stop, each once, the first one first.
std::vector<int> distinct(const std::vector<int>& asked, int deepest) {
  std::vector<int> depths;
  for (const int a : asked) {
    const int depth = std::min(a, deepest);
    if (std::find(depths.begin(), depths.end(), depth) == depths.end()) depths.push_back(depth);
  }
  return depths;
}

std::vector<Measured> measure(const DepthReport& report, const DepthOptions& options,
                              const std::vector<int>& depths, double budget, Announcer& announce) {
  SweepOptions o;
  o.budget = budget;
  o.most_samples = options.most_samples;
  o.pixels = report.reference.pixels.size();
  o.clock = clock_seconds;
  o.interrupted = interrupted;
  o.progress = [&](const std::string& next, double left) { announce(next, left); };
  std::vector<std::string> names;
  for (const int d : depths) names.push_back("depth " + std::to_string(d));
  const bool procedural = report.loaded.clouds.front().recipe() != nullptr;
  return sweep(names, o, [&](const RunRequest& r) {
    const int depth = depths[r.setting];
    // Samples are found whatever the octree's depth; a recipe only as far as the octree divides it.
    ChangeCloud limit;
    if (procedural) {
      limit = [depth](formats::Cloud& c) { c.pyramid = limit_depth(c.pyramid, depth); };
    }
    return render_changed(
        report.loaded, [depth](Scene& s) { s.options.depth = depth; }, limit, r, 1);
  });
}

DepthReport measure_depth(const DepthOptions& o) {
  DepthReport report;
  report.name = o.scene.input.string();
  report.budget = o.budget;
  report.loaded = load_scene(o.scene, kPixels);
  fix_choices(o, report.loaded);
  const double begin = clock_seconds();
  const auto left = [&] { return o.budget - (clock_seconds() - begin); };
  Announcer announce(o.quiet);
  catch_interrupt();
  const int last = deepest(report.loaded);
  const std::vector<int> depths = distinct(o.depths, last);
  announce("building for " + std::to_string(depths.size()) + " depths", left());
  const std::vector<BuildTimes> build =
      time_building(report.loaded, depths, begin + kBuildPart * o.budget);
  announce("the reference", left());
  constexpr std::uint64_t kReferenceSeeds = std::uint64_t(1) << 40;  // far from all others
  LoadedScene deep = report.loaded;
  deep.file.scene.options.depth = last;
  report.reference = render_reference(deep, kReferencePart * left(), kReferenceSeeds, 0);
  if (!(mean_luminance(report.reference) > 0)) {
    throw Error(report.name + ": the picture is black; there is no error to measure");
  }
  const std::vector<Measured> measured = measure(report, o, depths, left(), announce);
  for (const int asked : o.depths) {
    DepthRow row;
    row.asked = asked;
    row.depth = std::min(asked, last);
    const auto i = std::size_t(std::find(depths.begin(), depths.end(), row.depth) - depths.begin());
    row.measured = measured[i];
    row.build = build[i];
    report.rows.push_back(std::move(row));
  }
  relate(report);
  report.used = clock_seconds() - begin;
  return report;
}

}  // namespace

int run_depth(const DepthOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  const DepthReport report = measure_depth(o);
  if (o.html) write_depth_page(*o.html, report);
  if (o.json) {
    std::cout << to_text(depth_json(report));
  } else if (!o.quiet) {
    print_depth(report);
  }
  return kSuccess;
}

}  // namespace pvol::cli
