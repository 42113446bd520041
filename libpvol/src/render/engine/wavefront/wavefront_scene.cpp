#include "render/engine/wavefront/wavefront_scene.h"

#include "pvol/render/lighting.h"
#include "pvol/volume/facts.h"
#include "render/light/emission/emission_source.h"
#include "render/path/gather_light.h"

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

SimdLight make_simd_light(const LightSource& source, const Affine& world_to_cells) {
  SimdLight l;
  if (const auto* sun = std::get_if<SunLight>(&source)) {
    l.kind = sun->disc_pdf == 0 ? SimdLight::Kind::delta : SimdLight::Kind::disc;
    l.direction = sun->direction;
    l.one_minus_cos_radius = sun->one_minus_cos_radius;
    l.pdf = sun->disc_pdf;
    l.radiance = sun->disc_pdf == 0 ? sun->irradiance : sun->disc_radiance;
  } else {  // no others come here, see wavefront_obstacle
    const PointSource& point = std::get<PointSource>(source);
    l.kind = SimdLight::Kind::point;
    l.place = Vec3f(world_to_cells.point(point.position) + Vec3d(DenseBounds::kBorder));
    l.radiance = point.intensity;
  }
  l.value = absolute_luminance(l.radiance);
  return l;
}

}  // namespace

WavefrontScene::WavefrontScene(const PathSetup& s)
    : setup(s),
      volume(s.volumes.front()),
      to_world{Vec3f(volume.cells_to_world.m[0]), Vec3f(volume.cells_to_world.m[1]),
               Vec3f(volume.cells_to_world.m[2])},
      field(volume.volume.density, *s.dense),
      components(make_component_table(volume.components)),
      one_lobe(has_one_lobe(volume.components)) {
  // What is absorbed is in layers.
  emits = s.options.aovs.has(Aov::lights) && largest(s.constant) > 0;
  for (const MediumComponent& m : volume.components) emits = emits || largest(m.emitted) > 0;
  count = s.count;
  orders = s.options.aovs.has(Aov::scattering);
  counts_collisions = orders || s.max_bounces <= kMostWavefrontBounces;
  limited = false;
  weighted = s.light.sky.sampled();
  dark_sky = !s.light.sky.sampled() && largest(s.light.sky.radiance({0, 1, 0}) - s.constant) == 0 &&
             s.light.sky.is_constant();
  for (const LightSource& source : s.light.sources) {
    lights.push_back(make_simd_light(source, volume.volume.density.world_to_cells));
    limited = limited || std::holds_alternative<PointSource>(source);
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
}

const char* wavefront_obstacle(std::span<const Volume> volumes, const Scene& scene) {
  const RenderOptions& o = scene.options;
  if (count_places(volumes) != 1) return "there are several volumes";
  if (!scene.surfaces.empty()) return "there are surfaces";
  if (o.tracker != Tracker::decomposition) return "the tracker is not decomposition";
  if (o.transmittance != Transmittance::automatic && o.transmittance != Transmittance::analog) {
    return "shadow rays are not analog";
  }
  if (o.depth) return "the octree's depth is set by the user";
  if (o.majorant_scale != 1) return "majorants are scaled";
  if (o.max_bounces && *o.max_bounces > kMostWavefrontBounces) return "the bounce limit is high";
  const Volume& v = volumes.front();
  if (v.fire != nullptr) return "a field emits";
  if (v.albedo != nullptr) return "the albedo varies in space";
  if (is_chromatic(v.medium)) return "the extinction differs by channel";
  if (gathers_along_flights(v, o)) return "emission is gathered along flights";
  constexpr std::size_t kMostLights = 255;
  for (const LightSource& source : make_light_sources(scene.lights)) {
    const bool served =
        std::holds_alternative<SunLight>(source) || std::holds_alternative<PointSource>(source);
    if (!served) return "a light is neither a sun nor a point light";
  }
  if (most_lights(scene) > kMostLights) return "there are more than 255 lights";
  return simd_obstacle(v);
}

}  // namespace pvol::detail
