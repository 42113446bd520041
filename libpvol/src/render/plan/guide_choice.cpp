#include "pvol/render/guide_choice.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "pvol/error.h"
#include "pvol/render/lights.h"
#include "pvol/render/plan.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/estimators.h"
#include "render/light/smooth_luminance.h"

namespace pvol {
namespace {

/// Why paths cannot be guided, or null.
const char* obstacle(std::span<const Volume> volumes) {
  if (volumes.empty()) return "there is no volume";
  const auto excess = [](const Volume& v) { return v.density.majorant_excess; };
  if (std::ranges::any_of(volumes, [&](const Volume& v) { return excess(v) > 1; })) {
    return "where majorants do not hold, weights grow, and so would the number of paths";
  }
  return nullptr;
}

/// Whether enough of the light comes from somewhere rather than from everywhere: guided paths of
/// scenes under a smooth sky alone cost up to twice as much for the same noise.
bool has_directions(std::span<const Volume> volumes, const Lighting& lighting) {
  constexpr float kShare = 0.1f;  // of the sky's light: from there on guiding gains
  constexpr auto kSphere = 4 * std::numbers::pi_v<float>;
  float directed = kSphere * lighting.sky.mean_luminance();
  const Box box = world_box(volumes);
  for (const LightSource& source : make_light_sources(lighting.lights)) {
    if (box.empty()) return false;
    const auto irradiance = [&](const auto& l) { return l.irradiance_on(box); };
    directed += luminance(std::visit(irradiance, source));
  }
  if (directed > kShare * kSphere * detail::smooth_luminance(lighting.sky)) return true;
  return std::ranges::any_of(volumes, [](const Volume& v) { return emits(v.medium); });
}

/// From so many paths on photons are enough for the places of volumes: for a few by their number,
/// and for many, of which a camera sees some, all at once (tests/bench/RESULTS.md, a sky of many
/// clouds).
double least_paths(std::size_t places) {
  constexpr double kOfFew = 20'000, kAtOnce = 1 << 17, kOfMany = 1000;
  if (places <= 1) return 0;
  return std::max(std::min(kOfFew * double(places), kAtOnce), kOfMany * double(places));
}

}  // namespace

GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene, double paths) {
  return choose_guide(volumes, scene, make_lighting(scene), paths);
}

GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene,
                         const Lighting& lighting, double paths) {
  // Below these, guided and plain paths cost about the same for the same noise, or plain ones less
  // (tests/bench/clouds.py).
  constexpr double kThickness = 0.5, kAlbedo = 0.75;
  // Reading a cloud takes longer than its photons: from so few paths on, a command gains by them.
  constexpr double kPaths = 1 << 14;
  const RenderOptions& o = scene.options;
  if (o.guide == GuideUse::off) return {false, "as set"};
  if (const char* reason = obstacle(volumes)) {
    if (o.guide == GuideUse::automatic) return {false, reason};
    throw Error(std::string("paths cannot be guided: ") + reason +
                "; leave guide at auto, or change the scene");
  }
  if (o.guide == GuideUse::on) return {true, "as set"};
  if (o.max_bounces) return {false, "the number of bounces is limited"};
  if (!has_directions(volumes, lighting)) return {false, "light comes from a smooth sky alone"};
  const double thickness = choose_transmittance(volumes).thickness;
  double albedo = 0;
  for (const Volume& v : volumes) albedo = std::max(albedo, double(largest_albedo(v)));
  const double scatterings = estimate_scatterings(thickness, albedo);
  if (thickness < kThickness) return {false, "the cloud is thin", scatterings};
  if (albedo < kAlbedo) return {false, "the cloud absorbs much", scatterings};
  if (paths < kPaths) {
    return {false, "the picture takes less time than building a guide", scatterings};
  }
  if (paths < least_paths(count_places(volumes))) {
    return {false, "there are too few photons for so many volumes", scatterings};
  }
  return {true, "light comes from certain directions", scatterings};
}

}  // namespace pvol
