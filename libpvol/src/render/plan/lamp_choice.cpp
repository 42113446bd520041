#include "render/plan/lamp_choice.h"

#include <algorithm>
#include <numbers>

#include "pvol/render/lights.h"
#include "pvol/volume/estimators.h"
#include "render/light/lamp.h"
#include "render/light/smooth_luminance.h"

namespace pvol::detail {
namespace {

bool is_lamp(const Light& light) { return !std::holds_alternative<Sun>(light); }

/// Whether the noise of lamps matters: they bring much of the light that falls on the volumes, or
/// lie within, where nothing bounds it.
bool lamps_matter(const Box& box, const Lighting& lighting) {
  constexpr float kShare = 0.3f;
  float all = 4 * std::numbers::pi_v<float> *
              (lighting.sky.mean_luminance() + smooth_luminance(lighting.sky));
  float of_lamps = 0;
  for (const LightSource& source : make_light_sources(lighting.lights)) {
    const Lamp lamp = lamp_of(source);
    if (lamp.power > 0 && box.contains(lamp.position)) return true;
    const float light =
        luminance(std::visit([&](const auto& l) { return l.irradiance_on(box); }, source));
    (lamp.power > 0 ? of_lamps : all) += light;
  }
  return of_lamps > kShare * (all + of_lamps);
}

}  // namespace

std::vector<bool> choose_line_lamps(std::span<const Volume> volumes, const Scene& scene,
                                    const Lighting& lighting) {
  const RenderOptions& o = scene.options;
  std::vector<bool> all(volumes.size());
  const Box box = world_box(volumes);
  if (box.empty() || std::ranges::none_of(lighting.lights, is_lamp)) return all;
  if (o.line_lamps == LineLamps::off || o.deep) return all;
  const bool wanted = o.line_lamps == LineLamps::on;
  if (!wanted && !lamps_matter(box, lighting)) return all;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if (volumes[i].density.octree.empty()) continue;
    // In thicker clouds collisions alone cost less for the same noise (tests/bench/RESULTS.md).
    constexpr double kThin = 0.7;
    all[i] = wanted || choose_transmittance(volumes.subspan(i, 1)).thickness < kThin;
  }
  return all;
}

std::optional<Decision> decide_line_lamps(const RenderPlan& p, LineLamps wanted) {
  if (std::ranges::none_of(p.scene.lights, is_lamp) || world_box(p.volumes).empty()) return {};
  const auto asked = std::size_t(std::ranges::count(p.line_lamps, true));
  const bool matter = lamps_matter(world_box(p.volumes), *p.lighting);
  const char* reason = wanted != LineLamps::automatic ? "as set"
                       : p.scene.options.deep         ? "deep pictures consist of collisions"
                       : asked > 0                    ? "the cloud is thin"
                       : matter                       ? "the cloud is thick"
                                                      : "most light is of other kinds";
  return Decision{"lamps",
                  asked == 0                 ? "asked where paths collide"
                  : asked < p.volumes.size() ? "asked all along flights through some volumes"
                                             : "asked all along flights",
                  reason};
}

}  // namespace pvol::detail
