#include "stats/trade_variants.h"

#include <algorithm>
#include <cmath>

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

void add_depths(const LoadedScene& loaded, std::vector<Variant>& list) {
  int deepest = 0;
  for (const formats::Cloud& c : loaded.clouds) {
    deepest = std::max(deepest, int(c.pyramid.levels.size()) - 1);
  }
  std::vector<int> depths{0, 2, 3, 4, 6, 8, deepest};
  std::sort(depths.begin(), depths.end());
  depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
  for (const int depth : depths) {
    if (depth > deepest) break;
    list.push_back({.factor = kDepth,
                    .option = "--depth " + std::to_string(depth),
                    .scene = [depth](Scene& s) { s.options.depth = depth; }});
  }
}

void add_micro_bounds(std::vector<Variant>& list) {
  using M = MicroBoundsUse;
  for (const M use : {M::none, M::cells_8, M::cells_1}) {
    list.push_back({.factor = kMicroBounds,
                    .option = std::string("--micro-bounds ") + formats::name(use),
                    .scene = [use](Scene& s) { s.options.micro_bounds = use; }});
  }
}

void add_trackers(const LoadedScene& loaded, std::vector<Variant>& list) {
  using T = Tracker;
  for (const T tracker : {T::delta_global, T::delta, T::decomposition, T::weighted_delta,
                          T::weighted_decomposition, T::regular}) {
    if (tracker == loaded.file.scene.options.tracker) continue;
    if (is_weighted(tracker) && loaded.clouds.size() > 1) continue;
    list.push_back({.factor = kTracker,
                    .option = std::string("--tracker ") + formats::name(tracker),
                    .scene = [tracker](Scene& s) { s.options.tracker = tracker; }});
  }
}

void add_transmittances(std::vector<Variant>& list) {
  using T = Transmittance;
  for (const T t : {T::analog, T::ratio, T::residual_ratio, T::regular}) {
    list.push_back({.factor = kTransmittance,
                    .option = std::string("--transmittance ") + formats::name(t),
                    .scene = [t](Scene& s) { s.options.transmittance = t; }});
  }
}

/// Another interpolant is another field: its picture is not the default's.
void add_interpolations(const LoadedScene& loaded, std::vector<Variant>& list) {
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
    list.push_back({.factor = kLookUp,
                    .option = std::string("--interpolation ") + formats::name(i),
                    .biased = true,
                    .scene = [i](Scene& s) { s.options.look_up = i; },
                    .cloud = bound_again});
  }
}

void add_guides(std::vector<Variant>& list) {
  for (const GuideUse use : {GuideUse::on, GuideUse::off}) {
    list.push_back({.factor = kGuide,
                    .option = std::string("--guide ") + formats::name(use),
                    .scene = [use](Scene& s) { s.options.guide = use; }});
  }
}

/// Clouds that were not rounded before.
void add_densities(const LoadedScene& loaded, std::vector<Variant>& list) {
  for (const formats::Cloud& c : loaded.clouds) {
    if (c.recipe() || c.metadata.quantisation.precision != Precision::fp32) return;
  }
  for (const Precision p : {Precision::fp16, Precision::fp8, Precision::fpn}) {
    const auto round = [p](formats::Cloud& c) {
      formats::quantise(c, Quantisation{.precision = p}, c.metadata.source.file);
    };
    list.push_back({.factor = kDensity,
                    .option = std::string("--density ") + name(p),
                    .biased = true,
                    .cloud = round});
  }
}

void add_homogenised(const LoadedScene& loaded, std::vector<Variant>& list) {
  if (loaded.clouds.front().recipe() || loaded.file.scene.options.homogenise) return;
  for (const double tolerance : {0.1, 1.0, 10.0}) {
    list.push_back({.factor = kHomogenise,
                    .option = "--homogenise " + readable(tolerance),
                    .biased = true,
                    .scene = [tolerance](Scene& s) { s.options.homogenise = tolerance; }});
  }
}

void add_previews(const LoadedScene& loaded, std::vector<Variant>& list) {
  const int own = loaded.file.scene.options.preview;
  if (loaded.clouds.front().recipe()) return;
  for (const int more : {1, 2, 3}) {
    const auto halve = [more](formats::Cloud& c) {
      formats::coarsen(c, more, c.metadata.source.file);
    };
    list.push_back({.factor = kPreview,
                    .option = "--preview " + std::to_string(own + more),
                    .biased = true,
                    .cloud = halve});
  }
}

void add_shells(const LoadedScene& loaded, std::vector<Variant>& list) {
  const bool any = std::any_of(loaded.clouds.begin(), loaded.clouds.end(),
                               [](const formats::Cloud& c) { return c.shell.has_value(); });
  if (!any) return;
  for (const ShellUse use : {ShellUse::on, ShellUse::off}) {
    list.push_back({.factor = kShells,
                    .option = std::string("--shells ") + formats::name(use),
                    .scene = [use](Scene& s) { s.options.shells = use; }});
  }
}

void add_bounce_limits(const LoadedScene& loaded, std::vector<Variant>& list) {
  const auto& own = loaded.file.scene.options.max_bounces;
  for (const std::uint32_t most : {4u, 16u, 64u, 256u}) {
    if (own && *own <= most) continue;
    list.push_back({.factor = kBounces,
                    .option = "--max-bounces " + std::to_string(most),
                    .biased = true,
                    .scene = [most](Scene& s) { s.options.max_bounces = most; }});
  }
}

/// The best of each factor, the factor that gains most first: indices of settings.
std::vector<std::size_t> best_of_factors(const std::vector<Variant>& singles,
                                         const std::vector<VariantResult>& results, bool biased,
                                         double most_offset) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < singles.size(); ++i) {
    const VariantResult& r = results[i];
    if (r.measured && singles[i].biased == biased && r.proven_gain < 1 && r.offset <= most_offset) {
      order.push_back(i);
    }
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return results[a].gain < results[b].gain; });
  std::vector<std::size_t> best;
  for (const std::size_t i : order) {
    const bool taken = std::any_of(best.begin(), best.end(), [&](std::size_t b) {
      return singles[b].factor == singles[i].factor;
    });
    if (!taken) best.push_back(i);
  }
  return best;
}

}  // namespace

Variant default_variant() { return {.factor = "default", .option = ""}; }

std::vector<Variant> single_variants(const LoadedScene& loaded) {
  std::vector<Variant> list;
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

Variant combine(const Variant& a, const Variant& b) {
  const auto both = [](const auto& first, const auto& second) {
    using F = std::decay_t<decltype(first)>;
    if (!first || !second) return first ? first : second;
    return F([first, second](auto& changed) { first(changed), second(changed); });
  };
  return {a.factor + " + " + b.factor, a.option + ' ' + b.option, a.biased || b.biased,
          both(a.scene, b.scene), both(a.cloud, b.cloud)};
}

std::vector<Variant> combinations(const std::vector<Variant>& singles,
                                  const std::vector<VariantResult>& results) {
  constexpr std::size_t kFactors = 3, kBiasedFactors = 2;
  constexpr double kMostOffset = 0.02;
  std::vector<std::size_t> best = best_of_factors(singles, results, false, 0);
  if (best.size() > kFactors) best.resize(kFactors);
  std::vector<Variant> list;
  for (std::size_t i = 0; i < best.size(); ++i) {
    for (std::size_t j = i + 1; j < best.size(); ++j) {
      list.push_back(combine(singles[best[i]], singles[best[j]]));
    }
  }
  if (best.size() == 3) list.push_back(combine(list[0], singles[best[2]]));

  std::vector<std::size_t> biased = best_of_factors(singles, results, true, kMostOffset);
  if (biased.size() > kBiasedFactors) biased.resize(kBiasedFactors);
  if (biased.size() == 2) list.push_back(combine(singles[biased[0]], singles[biased[1]]));
  for (const std::size_t i : biased) {
    if (!best.empty()) list.push_back(combine(singles[i], singles[best[0]]));
  }
  return list;
}

}  // namespace pvol::cli
