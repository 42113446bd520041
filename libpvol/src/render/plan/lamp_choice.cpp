#include "render/plan/lamp_choice.h"

#include <algorithm>
#include <functional>

#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
#include "render/plan/lamp_trial.h"

namespace pvol::detail {
namespace {

bool is_lamp(const Light& light) { return !std::holds_alternative<Sun>(light); }

/// From there on collisions alone cost less for the same noise (tests/bench/RESULTS.md).
constexpr double kThin = 0.7;

std::vector<bool> thin_ones(std::span<const Volume> volumes) {
  std::vector<bool> thin;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    thin.push_back(!volumes[i].density.octree.empty() &&
                   choose_transmittance(volumes.subspan(i, 1)).thickness < kThin);
  }
  return thin;
}

/// Whether lamps that are asked along flights, as the plan has it, save more noise than they take
/// time.
bool pays(const RenderPlan& plan) {
  if (plan.kernel.endless) return true;  // a trial might not end
  const LampTrial trial = try_lamps(plan);
  return trial.variance_along * trial.time <= trial.variance_at_collisions;
}

}  // namespace

LampChoice choose_lamps(const RenderPlan& plan) {
  const RenderOptions& o = plan.scene.options;
  LampChoice choice{.along_flights = std::vector<bool>(plan.volumes.size())};
  if (world_box(plan.volumes).empty() || std::ranges::none_of(plan.lighting->lights, is_lamp)) {
    return choice;
  }
  const auto holds_any = [](const Volume& v) { return !v.density.octree.empty(); };
  if (o.line_lamps != LineLamps::automatic) {
    choice.reason = "as set";
    if (o.line_lamps == LineLamps::on) {
      std::transform(plan.volumes.begin(), plan.volumes.end(), choice.along_flights.begin(),
                     holds_any);
    }
    return choice;
  }
  if (o.deep) {
    choice.reason = "deep pictures consist of collisions";
    return choice;
  }
  RenderPlan asking = plan;
  asking.line_lamps = thin_ones(plan.volumes);
  if (std::ranges::none_of(asking.line_lamps, std::identity{})) {
    choice.reason = "the cloud is thick";
  } else if (!pays(asking)) {
    choice.reason = "little of the noise is theirs";
  } else {
    choice.reason = "the cloud is thin, and much of the noise is theirs";
    choice.along_flights = asking.line_lamps;
  }
  return choice;
}

Decision in_words(const LampChoice& choice) {
  const std::vector<bool>& along = choice.along_flights;
  const auto asked = std::size_t(std::ranges::count(along, true));
  return {"lamps",
          asked == 0             ? "asked where paths collide"
          : asked < along.size() ? "asked all along flights through some volumes"
                                 : "asked all along flights",
          choice.reason};
}

}  // namespace pvol::detail
