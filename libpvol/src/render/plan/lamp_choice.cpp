#include "render/plan/lamp_choice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/render/lights.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
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

/// From there on collisions alone cost less for the same noise (tests/bench/RESULTS.md).
constexpr double kThin = 0.7;

std::vector<double> thickness_of_each(std::span<const Volume> volumes) {
  std::vector<double> all;
  for (std::size_t i = 0; i < volumes.size(); ++i)
    all.push_back(choose_transmittance(volumes.subspan(i, 1)).thickness);
  return all;
}

/// Of the light of lamps, what a volume scatters, about: it falls on the boxes of its places, of
/// which many are told by some.
double scattered_by(const Volume& v, double thickness, std::span<const LightSource> lights) {
  constexpr std::size_t kMostPlaces = 64;
  const std::size_t places = count_places(v), step = 1 + (places - 1) / kMostPlaces;
  double sum = 0;
  for (std::size_t place = 0; place < places; place += step) {
    const Box box = world_box(v.density, v, place);
    const Vec3d e = box.extent();
    const double shadow = 0.5 * (e.x * e.y + e.y * e.z + e.z * e.x);  // its mean (Cauchy)
    for (const LightSource& light : lights) {
      const auto irradiance = [&](const auto& l) { return luminance(l.irradiance_on(box)); };
      if (lamp_of(light).power > 0) sum += shadow * double(std::visit(irradiance, light));
    }
  }
  return sum * double(step) * -std::expm1(-thickness) * double(largest_albedo(v));
}

/// Why lamps are not asked along flights, or null. Light that thick volumes scatter onto thin ones
/// reaches these by scattered paths alone: where there is much of it, its noise is that of the
/// picture, and places along flights are looked up for nothing.
const char* why_not_along(std::span<const Volume> volumes, std::span<const double> thickness,
                          const Lighting& lighting) {
  constexpr double kShare = 0.4;  // tests/bench/RESULTS.md
  double thin = 0, thick = 0;
  const std::vector<LightSource> lights = make_light_sources(lighting.lights);
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if (volumes[i].density.octree.empty()) continue;
    (thickness[i] < kThin ? thin : thick) += scattered_by(volumes[i], thickness[i], lights);
  }
  if (thin == 0) return "the cloud is thick";
  return thick > kShare * thin ? "thick clouds scatter much of it onto thin ones" : nullptr;
}

}  // namespace

LampChoice choose_lamps(std::span<const Volume> volumes, const Scene& scene,
                        const Lighting& lighting) {
  const RenderOptions& o = scene.options;
  LampChoice choice{.along_flights = std::vector<bool>(volumes.size())};
  const Box box = world_box(volumes);
  if (box.empty() || std::ranges::none_of(lighting.lights, is_lamp)) return choice;
  const auto holds_any = [](const Volume& v) { return !v.density.octree.empty(); };
  if (o.line_lamps != LineLamps::automatic) {
    choice.reason = "as set";
    if (o.line_lamps == LineLamps::on)
      std::transform(volumes.begin(), volumes.end(), choice.along_flights.begin(), holds_any);
    return choice;
  }
  choice.reason = o.deep                         ? "deep pictures consist of collisions"
                  : !lamps_matter(box, lighting) ? "most light is of other kinds"
                                                 : nullptr;
  if (choice.reason) return choice;
  const std::vector<double> thickness = thickness_of_each(volumes);
  choice.reason = why_not_along(volumes, thickness, lighting);
  if (choice.reason) return choice;
  choice.reason = "the cloud is thin";
  for (std::size_t i = 0; i < volumes.size(); ++i)
    choice.along_flights[i] = holds_any(volumes[i]) && thickness[i] < kThin;
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
