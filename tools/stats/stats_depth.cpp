// The verb `depth`: what the octree's depth costs and gains on the user's own cloud.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "cli/cli.h"
#include "cli/instructions.h"
#include "cli/load_scene.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/field/procedural.h"
#include "pvol/measure/study.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/estimators.h"
#include "report/html.h"
#include "report/terminal.h"
#include "stats/depth_report.h"
#include "stats/stats_trade.h"
#include "stats/study_clock.h"

namespace pvol::cli {
namespace {

constexpr double kBuildPart = 0.2;
constexpr int kBuildRounds = 6, kFewestBuildRounds = 2;

/// The level at which walks stop that no depth limits: a greater depth changes nothing.
int deepest(const LoadedScene& loaded) {
  Scene scene = loaded.file.scene;
  scene.options.depth.reset();
  int depth = 0;
  for (std::size_t k = 0; k < loaded.clouds.size(); ++k) {
    const Volume volume = make_volume(loaded.clouds[k], loaded.file.volumes[k], scene);
    depth = std::max(depth, volume.density.octree.depth);
  }
  return depth;
}

/// What `auto` would choose by the depth is chosen once, without a limit, so that only the depth
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
  scene.options.depth.reset();
  const Volume volume = make_volume(loaded.clouds.front(), loaded.file.volumes.front(), scene);
  r.transmittance = choose_transmittance(std::span(&volume, 1)).estimator;
}

/// Builds bounds and trees of all clouds for each depth, in turn.
std::vector<measure::BuildTimes> time_building(const LoadedScene& loaded,
                                               const std::vector<int>& depths, double end) {
  std::vector<measure::BuildTimes> times(depths.size());
  std::vector<formats::Cloud> clouds = loaded.clouds;
  for (int round = 0; round < kBuildRounds; ++round) {
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
        const Volume volume = make_volume(c, loaded.file.volumes[k], scene);
        bounds += middle - begin, tree += cpu_seconds() - middle;
      }
      times[i].bounds.push_back(bounds), times[i].tree.push_back(tree);
    }
  }
  return times;
}

/// Depths that differ, each once, the first one first.
std::vector<int> distinct(const std::vector<int>& asked, int deepest) {
  std::vector<int> depths;
  for (const int a : asked) {
    const int depth = std::min(a, deepest);
    if (std::find(depths.begin(), depths.end(), depth) == depths.end()) depths.push_back(depth);
  }
  return depths;
}

/// Each of these depths, in turn.
std::vector<measure::Measured> measure(StudyClock& clock, const StudyReport& report,
                                       const std::vector<int>& depths, std::uint32_t most_samples) {
  std::vector<std::string> names;
  for (const int d : depths) names.push_back(fmt::format("depth {}", d));
  const bool procedural = report.loaded.clouds.front().recipe() != nullptr;
  return clock.sweep(names, clock.left(), 1, most_samples, {}, [&](const measure::RunRequest& r) {
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

/// A row for each depth asked for, of the depths measured.
void study_depths(DepthReport& report, const std::vector<int>& asked, int last,
                  const std::vector<int>& depths, const std::vector<measure::Measured>& measured,
                  const std::vector<measure::BuildTimes>& build) {
  std::vector<measure::Variant> variants;
  std::vector<measure::Measured> of_variants;
  for (const int a : asked) {
    const int depth = std::min(a, last);
    const auto i = std::size_t(std::find(depths.begin(), depths.end(), depth) - depths.begin());
    report.depths.push_back({a, depth, build[i]});
    variants.push_back({"octree depth", "depth " + depth_text(report.depths.back())});
    of_variants.push_back(measured[i]);
  }
  report.base.study.rows = measure::make_rows(variants, std::move(of_variants));
  measure::test_biases(report.base.study);
}

DepthReport measure_depth(const DepthOptions& o) {
  DepthReport report;
  StudyReport& base = report.base;
  base.name = o.scene.input.string();
  base.budget = o.budget;
  base.loaded = load_scene(o.scene, kPixelsOfStudy, o.quiet);
  fix_choices(o, base.loaded);
  StudyClock clock(base, o.quiet);
  const int last = deepest(base.loaded);
  const std::vector<int> depths = distinct(o.depths, last);
  clock.announce(fmt::format("building for {} depths", depths.size()));
  const std::vector<measure::BuildTimes> build =
      time_building(base.loaded, depths, clock_seconds() + kBuildPart * clock.left());
  LoadedScene deep = base.loaded;
  deep.file.scene.options.depth = last;
  clock.measure_reference(deep, kReferencePart, 0);
  study_depths(report, o.depths, last, depths, measure(clock, base, depths, o.most_samples), build);
  clock.stop();
  return report;
}

}  // namespace

int run_depth(const DepthOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  const DepthReport report = measure_depth(o);
  const report::Document document = depth_document(report, o.html.has_value());
  if (o.html) html::write_page(*o.html, document);
  if (o.json) {
    std::cout << to_text(depth_json(report));
  } else if (!o.quiet) {
    std::cout << report::to_terminal(document);
  }
  StudyClock::require_whole();
  return kSuccess;
}

}  // namespace pvol::cli
