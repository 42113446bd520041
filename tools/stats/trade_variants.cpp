#include "stats/trade_variants.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

/// The factors in the order of the report.
constexpr const char* kDepth = "octree depth";
constexpr const char* kMicroBounds = "micro-bounds";
constexpr const char* kTracker = "tracker";
constexpr const char* kTransmittance = "shadow rays";
constexpr const char* kLookUp = "interpolation";
constexpr const char* kShells = "shells";
constexpr const char* kBounces = "bounce limit";
constexpr const char* kGuide = "guided paths";
constexpr const char* kDensity = "density";
constexpr const char* kHomogenise = "homogenised nodes";
constexpr const char* kPreview = "preview";

void add_depths(const LoadedScene& loaded, std::vector<Candidate>& list) {
  int deepest = 0;
  for (const formats::Cloud& c : loaded.clouds) {
    deepest = std::max(deepest, int(c.pyramid.levels.size()) - 1);
  }
  std::vector<int> depths{0, 2, 3, 4, 6, 8, deepest};
  std::sort(depths.begin(), depths.end());
  depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
  for (const int depth : depths) {
    if (depth > deepest) break;
    list.push_back({.variant = {kDepth, fmt::format("--depth {}", depth)},
                    .scene = [depth](Scene& s) { s.options.depth = depth; }});
  }
}

void add_micro_bounds(std::vector<Candidate>& list) {
  using M = MicroBoundsUse;
  for (const M use : {M::none, M::cells_8, M::cells_1}) {
    list.push_back({.variant = {kMicroBounds, fmt::format("--micro-bounds {}", formats::name(use))},
                    .scene = [use](Scene& s) { s.options.micro_bounds = use; }});
  }
}

void add_trackers(const LoadedScene& loaded, std::vector<Candidate>& list) {
  using T = Tracker;
  for (const T tracker : {T::delta_global, T::delta, T::decomposition, T::weighted_delta,
                          T::weighted_decomposition, T::regular}) {
    if (tracker == loaded.file.scene.options.tracker) continue;
    if (is_weighted(tracker) && loaded.clouds.size() > 1) continue;
    list.push_back({.variant = {kTracker, fmt::format("--tracker {}", formats::name(tracker))},
                    .scene = [tracker](Scene& s) { s.options.tracker = tracker; }});
  }
}

void add_transmittances(std::vector<Candidate>& list) {
  using T = Transmittance;
  for (const T t : {T::analog, T::ratio, T::residual_ratio, T::regular}) {
    list.push_back(
        {.variant = {kTransmittance, fmt::format("--transmittance {}", formats::name(t))},
         .scene = [t](Scene& s) { s.options.transmittance = t; }});
  }
}

/// Another interpolant is another field: its picture is not the default's.
void add_interpolations(const LoadedScene& loaded, std::vector<Candidate>& list) {
  using I = LookUp;
  const I own = loaded.file.scene.options.look_up;
  if (own == I::procedural) return;  // there are no samples
  for (const I i : {I::nearest, I::trilinear, I::tricubic}) {
    if (i == own) continue;
    const auto bound_again = [i](formats::Cloud& c) {
      if (holds_for(c.pyramid.look_up, i)) return;
      c.pyramid = formats::build_bounds(c.grid(), c.metadata.source.file, i);
      c.micro.reset();
      c.shell.reset();  // proven for the support that the other interpolation has
    };
    list.push_back({.variant = {kLookUp, fmt::format("--interpolation {}", formats::name(i)), true},
                    .scene = [i](Scene& s) { s.options.look_up = i; },
                    .cloud = bound_again});
  }
}

void add_guides(std::vector<Candidate>& list) {
  for (const GuideUse use : {GuideUse::on, GuideUse::off}) {
    list.push_back({.variant = {kGuide, fmt::format("--guide {}", formats::name(use))},
                    .scene = [use](Scene& s) { s.options.guide = use; }});
  }
}

/// Clouds that were not rounded before.
void add_densities(const LoadedScene& loaded, std::vector<Candidate>& list) {
  for (const formats::Cloud& c : loaded.clouds) {
    if (c.recipe() || c.metadata.quantisation.precision != Precision::fp32) return;
  }
  for (const Precision p : {Precision::fp16, Precision::fp8, Precision::fpn}) {
    const auto round = [p](formats::Cloud& c) {
      formats::quantise(c, Quantisation{.precision = p}, c.metadata.source.file);
    };
    list.push_back(
        {.variant = {kDensity, fmt::format("--density {}", name(p)), true}, .cloud = round});
  }
}

void add_homogenised(const LoadedScene& loaded, std::vector<Candidate>& list) {
  if (loaded.clouds.front().recipe() || loaded.file.scene.options.homogenise) return;
  for (const double tolerance : {0.1, 1.0, 10.0}) {
    list.push_back({.variant = {kHomogenise, fmt::format("--homogenise {:.4g}", tolerance), true},
                    .scene = [tolerance](Scene& s) { s.options.homogenise = tolerance; }});
  }
}

void add_previews(const LoadedScene& loaded, std::vector<Candidate>& list) {
  const int own = loaded.file.scene.options.preview;
  if (loaded.clouds.front().recipe()) return;
  for (const int more : {1, 2, 3}) {
    const auto halve = [more](formats::Cloud& c) {
      formats::coarsen(c, more, c.metadata.source.file);
    };
    list.push_back(
        {.variant = {kPreview, fmt::format("--preview {}", own + more), true}, .cloud = halve});
  }
}

void add_shells(const LoadedScene& loaded, std::vector<Candidate>& list) {
  const bool any = std::any_of(loaded.clouds.begin(), loaded.clouds.end(),
                               [](const formats::Cloud& c) { return c.shell.has_value(); });
  if (!any) return;
  for (const ShellUse use : {ShellUse::on, ShellUse::off}) {
    list.push_back({.variant = {kShells, fmt::format("--shells {}", formats::name(use))},
                    .scene = [use](Scene& s) { s.options.shells = use; }});
  }
}

void add_bounce_limits(const LoadedScene& loaded, std::vector<Candidate>& list) {
  const auto& own = loaded.file.scene.options.max_bounces;
  for (const std::uint32_t most : {4u, 16u, 64u, 256u}) {
    if (own && *own <= most) continue;
    list.push_back({.variant = {kBounces, fmt::format("--max-bounces {}", most), true},
                    .scene = [most](Scene& s) { s.options.max_bounces = most; }});
  }
}

}  // namespace

Candidate default_candidate() { return {.variant = {"default", ""}}; }

std::vector<Candidate> single_candidates(const LoadedScene& loaded) {
  std::vector<Candidate> list;
  add_depths(loaded, list);
  add_micro_bounds(list);
  add_trackers(loaded, list);
  add_transmittances(list);
  add_guides(list);
  add_shells(loaded, list);
  add_interpolations(loaded, list);
  add_densities(loaded, list);
  add_homogenised(loaded, list);
  add_previews(loaded, list);
  add_bounce_limits(loaded, list);
  return list;
}

Candidate combine(const Candidate& a, const Candidate& b) {
  const auto both = [](const auto& first, const auto& second) {
    using F = std::decay_t<decltype(first)>;
    if (!first || !second) return first ? first : second;
    return F([first, second](auto& changed) { first(changed), second(changed); });
  };
  return {{fmt::format("{} + {}", a.variant.factor, b.variant.factor),
           fmt::format("{} {}", a.variant.option, b.variant.option),
           a.variant.biased || b.variant.biased},
          both(a.scene, b.scene),
          both(a.cloud, b.cloud)};
}

std::vector<Candidate> combinations(const std::vector<Candidate>& singles,
                                    const std::vector<measure::VariantResult>& results) {
  std::vector<measure::Variant> variants;
  for (const Candidate& c : singles) variants.push_back(c.variant);
  std::vector<Candidate> list;
  for (const std::vector<std::size_t>& parts : measure::combinations(variants, results)) {
    list.push_back(singles[parts[0]]);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      list.back() = combine(list.back(), singles[parts[i]]);
    }
  }
  return list;
}

}  // namespace pvol::cli
