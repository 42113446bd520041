#include "render/engine/wavefront/wavefront_scene.h"

#include <algorithm>

#include "pvol/render/lighting.h"
#include "pvol/volume/facts.h"
#include "render/engine/wavefront/wavefront_memory.h"
#include "render/path/gather_light.h"
#include "volume/cell_look_up.h"

namespace pvol::detail {
namespace {

void add_lobe(const HenyeyGreenstein& hg, ComponentTable::Lobe& to) {
  to.g.push_back(hg.g);
  to.one_minus_g.push_back(hg.one_minus_g);
  to.one_minus_g2.push_back(hg.one_minus_g2);
  to.axis.push_back(hg.axis);
}

ComponentTable make_component_table(const std::vector<MediumComponent>& all) {
  ComponentTable t;
  for (const MediumComponent& m : all) {
    t.share_up_to.push_back(m.share_up_to);
    for (std::size_t c = 0; c < 3; ++c) t.albedo[c].push_back(m.albedo[int(c)]);
    TwoLobes two{HenyeyGreenstein(0), HenyeyGreenstein(0), 1};
    if (const auto* one = std::get_if<HenyeyGreenstein>(&m.phase)) {
      two.forward = two.backward = *one;
    } else if (const auto* both = std::get_if<TwoLobes>(&m.phase)) {
      two = *both;
    } else {
      t.one_by_one = all;
    }
    t.lobe_share.push_back(float(two.share));
    add_lobe(two.forward, t.lobes[0]);
    add_lobe(two.backward, t.lobes[1]);
  }
  return t;
}

bool has_one_lobe(const std::vector<MediumComponent>& all) {
  const MediumComponent& m = all.front();
  return all.size() == 1 && std::holds_alternative<HenyeyGreenstein>(m.phase) &&
         m.albedo.x == m.albedo.y && m.albedo.y == m.albedo.z;
}

SimdLight simd_light(const SunLight& sun, const Affine&) {
  const bool delta = sun.disc_pdf == 0;
  return {.kind = delta ? SimdLight::Kind::delta : SimdLight::Kind::disc,
          .direction = sun.direction,
          .one_minus_cos_radius = sun.one_minus_cos_radius,
          .pdf = sun.disc_pdf,
          .radiance = delta ? sun.irradiance : sun.disc_radiance};
}
SimdLight simd_light(const PointSource& point, const Affine& world_to_cells) {
  return {.kind = SimdLight::Kind::point,
          .place = Vec3f(world_to_cells.point(point.position) + Vec3d(DenseBounds::kBorder)),
          .radiance = point.color()};
}
template <class AtAPlace>
SimdLight simd_light(const AtAPlace& light, const Affine&) {
  return {.kind = SimdLight::Kind::other, .radiance = light.color()};
}

SimdLight make_simd_light(const LightSource& source, const Affine& world_to_cells) {
  SimdLight l =
      std::visit([&](const auto& light) { return simd_light(light, world_to_cells); }, source);
  l.value = absolute_luminance(l.radiance);
  return l;
}

}  // namespace

WavefrontScene::WavefrontScene(const PathSetup& s, std::size_t number)
    : setup(s),
      volume(s.volumes[number]),
      many(fly_in_the_world(s)),
      to_world{Vec3f(volume.cells_to_world.m[0]), Vec3f(volume.cells_to_world.m[1]),
               Vec3f(volume.cells_to_world.m[2])},
      field(volume.volume.density, (*s.dense)[number]),
      components(make_component_table(volume.components)),
      one_lobe(std::ranges::all_of(
                   s.volumes, [](const VolumeSetup& v) { return has_one_lobe(v.components); }) &&
               !s.albedo_varies && !s.by_channel &&
               (s.surfaces == nullptr || s.surfaces->are_grey())),
      drawn(s.light.drawn_in_volumes),
      lines((!many || s.free_radii.any()) && (s.flights_bring_light() || volume.asks_lamps)) {
  // What is absorbed is in layers.
  emits = s.options.aovs.has(Aov::lights) && largest(s.constant) > 0;
  for (const MediumComponent& m : volume.components) {
    emits = emits || largest(s.albedo_varies ? m.source : m.emitted) > 0;
  }
  count = s.count;
  times = many && (s.moving || volume.volume.density.motion != nullptr);
  orders = s.options.aovs.has(Aov::scattering);
  counts_collisions = orders || s.max_bounces <= kMostBounces;
  limited = many;
  ratio = s.options.transmittance != Transmittance::analog || s.weighs;
  share = volume.volume.medium.extinction_color;
  weighted = ratio || s.light.sky.sampled() || s.flights_bring_light();
  dark_sky = !s.light.sky.sampled() && largest(s.light.sky.radiance({0, 1, 0}) - s.constant) == 0 &&
             s.light.sky.is_constant();
  for (const LightSource& source : s.light.sources) {
    lights.push_back(make_simd_light(source, volume.volume.density.world_to_cells));
    // Cells differ from place to place.
    if (many && lights.back().kind == SimdLight::Kind::point)
      lights.back().kind = SimdLight::Kind::other;
    limited = limited || !std::holds_alternative<SunLight>(source);
    const bool seen = lights.back().kind == SimdLight::Kind::disc;
    weighted = weighted || seen;
    dark_sky = dark_sky && !seen;
  }
  if (s.light.sky.sampled()) lights.emplace_back();
  const auto bit = [](std::size_t f) { return std::uint32_t(1) << f; };
  fields = bit(kX) | bit(kY) | bit(kZ) | bit(kDX) | bit(kDY) | bit(kDZ) | bit(kW0) | bit(kDepth) |
           bit(kRng0) | bit(kRng1) | bit(kId);
  if (!one_lobe) fields |= bit(kW1) | bit(kW2);
  if (limited) fields |= bit(kLeft);
  if (weighted) fields |= bit(kPdf);
  if (many) {
    fields |= bit(kStepX) | bit(kStepY) | bit(kStepZ) | bit(kRay);
    field.step_field = kStepX;
    if (times) fields |= bit(kTime);
    if (volume.volume.density.motion != nullptr) field.time_field = kTime;
  }
  along = lines && (s.light.met.any() || volume.asks_lamps ||
                    (s.emission != nullptr && !s.emission->lines.sources.empty()));
  fire_in_lanes = volume.fire != nullptr && has_values_in_lanes(volume.volume.density) &&
                  has_values_in_lanes(volume.fire->fire());
  const auto emits_outside = [&] {
    return s.emission &&
           !std::ranges::all_of(s.emission->lines.sources, &EmissionSource::is_medium);
  };
  const bool camera_meets_lights = s.light.met.any() && s.depths == nullptr;
  camera_lines = lines && (s.emission != nullptr || volume.asks_lamps || camera_meets_lights);
  lines_outside = lines && (camera_meets_lights || emits_outside());
  if (lines) fields |= bit(kFromX) | bit(kFromY) | bit(kFromZ);
}

std::vector<WavefrontScene> make_wavefront_scenes(const PathSetup& s) {
  std::vector<WavefrontScene> all;
  for (std::size_t i = 0; i < s.volumes.size(); ++i) all.emplace_back(s, i);
  return all;
}

}  // namespace pvol::detail
