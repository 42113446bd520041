#include "render/light/emission/emission_source.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
#include "render/light/emission/collision_limit.h"
#include "volume/any_source.h"
#include "volume/cell_look_up.h"

namespace pvol::detail {
namespace {

constexpr double kStride = 8;  // cells, the edge of a leaf

/// Sum over the components of how much of their emission counts, per unit of optical depth.
template <class Part>
Rgb emitted(const Medium& medium, const Part& part) {
  Rgb sum(0.0f);
  for (const Component& c : medium.components) sum += part(c.albedo) * c.emission * float(c.share);
  return sum * medium.extinction_color;
}

/// What the medium of a volume emits, all components together: (1 - albedo x colour) L_e, and
/// nothing else.
EmissionSource source_of(const Volume& v) {
  const auto by_albedo = [](Rgb albedo) { return albedo; };
  const auto absorbed = [](Rgb albedo) { return Rgb(1.0f) - albedo; };
  const auto all = [](Rgb) { return Rgb(1.0f); };
  if (v.albedo == nullptr) return {.field = &v.density, .of_depth = emitted(v.medium, absorbed)};
  return {.field = &v.density,
          .of_depth = emitted(v.medium, all),
          .albedo = v.albedo.get(),
          .per_color = emitted(v.medium, by_albedo)};
}

template <class Value>
Rgb integrate(const EmissionSource& source, const Value& value, const Ray& ray, const Ray& cells,
              Span span, float time, float u, int fewer) {
  constexpr float kGolden = 0.618034f;  // steps by it spread over [0, 1) evenly
  const Octree& tree = source.lines();
  Walk walk(tree, make_cursor(tree, cells.at(span.t0)), widen(Vec3f(cells.d)), span.t1 - span.t0);
  const double pieces = length(cells.d) * fewer_points(source.points, fewer) / kStride;
  const int least = fewer_points(source.least, fewer);
  const bool colored = source.albedo != nullptr || (source.fire && source.fire->color_by);
  const bool colors_move = colored && source.field->motion != nullptr;
  const Affine to_world = colors_move ? inverse(source.field->world_to_cells) : Affine{};
  Rgb sum(0.0f);
  while (const auto s = walk.next()) {
    const double length = s->t1 - s->t0;
    const int count = std::max(least, int(std::ceil(std::min(length * pieces, 1e6))));
    const double piece = length / count;
    for (int k = 0; k < count; ++k) {
      const double t = s->t0 + (k + double(u)) * piece;
      const LatticePoint p = walk.point(t);
      const Vec3d place = colors_move
                              ? to_world.point(place_at_rest(*source.field, time, position(p)))
                              : ray.at(span.t0 + t);
      sum += source.at(value, *s, p, place) * float(piece);
      u += kGolden;
      if (u >= 1) u -= 1;
    }
  }
  return sum;
}

}  // namespace

bool gathers_along_flights(const Volume& volume, const RenderOptions& options) {
  // A uniform slab of depth tau brings noise of about tau^3 / 3 along flights and tau at
  // collisions; they cross over at 1.4 (THEORY.md, T5.11).
  constexpr double kThin = 1.4;
  if (source_of(volume).of_depth == Rgb(0.0f)) return false;
  if (options.deep) return false;  // whose samples lie where paths collide
  if (options.line_emission != LineEmission::automatic) {
    return options.line_emission == LineEmission::on;
  }
  return choose_transmittance(std::span(&volume, 1)).thickness < kThin;
}

namespace {

/// Null where all of a fire's light is gathered along flights.
std::shared_ptr<const FireAtCollisions> score_at_collisions(const Volume& volume,
                                                            const RenderOptions& options) {
  if (volume.density.octree.empty() || volume.fire->field.octree.empty()) return nullptr;
  if (options.line_emission == LineEmission::on) return nullptr;
  const double most = options.line_emission == LineEmission::off
                          ? double(std::numeric_limits<float>::max())
                          : brightest_at_collisions(volume, options.emission_points);
  if (!(most > 0)) return nullptr;
  auto scored = std::make_shared<const FireAtCollisions>(volume, most);
  return scored->holds_any() ? scored : nullptr;
}

EmissionSource source_of_fire(const Volume& v, const RenderOptions& options) {
  const Emitter& fire = *v.fire;
  EmissionSource source{.field = &fire.field,
                        .fire = &fire,
                        .points = options.emission_points,
                        .least = options.emission_points,
                        .at_collisions = score_at_collisions(v, options),
                        .in_lanes = has_values_in_lanes(fire)};
  if (fire.color_by) {
    source.cells_to_color = fire.color_by->world_to_cells * inverse(fire.field.world_to_cells);
  }
  return source;
}

/// Adds the source at each place of its volume, one of `volumes`.
void add_places(std::span<const Volume> volumes, const Volume& v, EmissionSource source,
                std::vector<EmissionSource>& to) {
  if (source.field->octree.empty()) return;
  source.volume = std::size_t(&v - volumes.data());
  for (std::size_t place = 0; place < count_places(v); ++place) {
    source.to_first = to_first_place(v, place);
    source.moves = place_moves(v, place) ? &v.moving_places->all[place] : nullptr;
    source.object_to_first = v.object_to_world;
    source.box = world_box(*source.field, v, place);
    to.push_back(source);
  }
}

}  // namespace

std::vector<EmissionSource> emission_sources(std::span<const Volume> volumes,
                                             const RenderOptions& options) {
  std::vector<EmissionSource> all;
  for (const Volume& v : volumes) {
    if (v.fire != nullptr) add_places(volumes, v, source_of_fire(v, options), all);
    if (!gathers_along_flights(v, options)) continue;
    EmissionSource medium = source_of(v);
    // Where flights end makes for more noise than the points up to there.
    medium.points = medium.least = std::max(options.emission_points / 2, 1);
    add_places(volumes, v, medium, all);
  }
  return all;
}

std::vector<EmissionSource> depth_sources(std::span<const Volume> volumes) {
  constexpr double kBetween = 0.5, kLeast = 4;  // optical depth between points; points of a leaf
  std::vector<EmissionSource> all;
  for (const Volume& v : volumes) {
    const double points = std::ceil(kLeafEdge * thickest_cell(v) / kBetween);
    add_places(volumes, v,
               {.field = &v.density,
                .of_depth = v.medium.extinction_color,
                .points = int(std::clamp(points, kLeast, 1e6))},
               all);
  }
  return all;
}

Rgb integrate(const EmissionSource& source, const Ray& world, double distance, float time, float u,
              int fewer) {
  const VolumeField& f = *source.field;
  const Affine to_first = source.to_first_at(time);
  const Ray ray{to_first.point(world.o), to_first.vector(world.d)};
  const Ray cells{f.world_to_cells.point(ray.o), f.world_to_cells.vector(ray.d)};
  const auto span = intersect(source.lines().support(), cells, 0, distance);
  if (!span) return Rgb(0.0f);
  return visit_source_at(f, time, [&](const auto& value) {
    return integrate(source, value, ray, cells, *span, time, u, fewer);
  });
}

}  // namespace pvol::detail
