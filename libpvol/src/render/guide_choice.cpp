#include "pvol/render/guide_choice.h"

#include <algorithm>
#include <string>

#include "pvol/error.h"
#include "pvol/render/plan.h"
#include "pvol/volume/estimators.h"

namespace pvol {
namespace {

/// Why paths cannot be guided, or null.
const char* obstacle(std::span<const Volume> volumes, const RenderOptions& o) {
  if (volumes.size() != 1) return "there are several volumes";
  if (is_weighted(o.tracker)) return "the tracker has weights";
  if (o.max_bounces) return "bounces are limited";
  if (o.look_up != LookUp::nearest && o.look_up != LookUp::trilinear) {
    return "the interpolation is neither nearest nor trilinear";
  }
  return nullptr;
}

/// Whether light comes from somewhere rather than from everywhere: guided paths of scenes under a
/// smooth sky alone cost twice as much for the same noise.
bool has_directions(std::span<const Volume> volumes, const Scene& scene) {
  if (!scene.lights.empty() || std::holds_alternative<ImageSky>(scene.environment)) return true;
  const std::vector<Component>& all = volumes.front().medium.components;
  return std::any_of(all.begin(), all.end(),
                     [](const Component& c) { return c.emission != Rgb(0.0f); });
}

}  // namespace

GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene, double paths) {
  constexpr double kScatterings = 5;  // of a path, from which on guiding has something to choose
  constexpr double kPaths = 1 << 17;  // that take longer than the photons
  const RenderOptions& o = scene.options;
  if (o.guide == GuideUse::off) return {false, "as told"};
  if (const char* reason = obstacle(volumes, o)) {
    if (o.guide == GuideUse::automatic) return {false, reason};
    throw Error(std::string("paths cannot be guided: ") + reason +
                "; leave guide at auto, or change that");
  }
  if (o.guide == GuideUse::on) return {true, "as told"};
  if (!has_directions(volumes, scene)) return {false, "light comes from a smooth sky alone"};
  const double thickness = choose_transmittance(volumes).thickness;
  const double scatterings =
      estimate_scatterings(thickness, double(largest_albedo(volumes.front().medium)));
  if (scatterings < kScatterings) return {false, "paths are short", scatterings};
  if (paths < kPaths) {
    return {false, "the picture takes less time than a guide", scatterings};
  }
  return {true, "paths are long", scatterings};
}

}  // namespace pvol
