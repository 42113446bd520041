// Emission and optical depths along lines: of even media and of fires in lanes, of the rest line by
// line (THEORY.md, T5.11).

#if defined(PVOL_LANE_ALONG_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_ALONG_INL_H
#undef PVOL_LANE_ALONG_INL_H
#else
#define PVOL_LANE_ALONG_INL_H
#endif

#include "render/engine/wavefront/wavefront_scene.h"
#include "volume/simd/emission-inl.h"
#include "volume/simd/lines-inl.h"
#include "volume/simd/values-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// The part of a ray of the world, up to a distance, in the box around a source's lines; none
/// passes it by.
[[nodiscard]] HWY_INLINE std::optional<Line> line_through(const EmissionSource& source,
                                                          const Ray& world, double distance,
                                                          float time) {
  const VolumeField& field = *source.field;
  const Affine to_first = source.to_first_at(time);
  const Vec3d from = field.world_to_cells.point(to_first.point(world.o));
  const Vec3d step = field.world_to_cells.vector(to_first.vector(world.d));
  const auto span = intersect(source.lines().support(), {from, step}, 0, distance);
  if (!span) return std::nullopt;
  const double length = span->t1 - span->t0;
  return Line{Vec3f(from + step * span->t0 + Vec3d(DenseBounds::kBorder)), Vec3f(step * length),
              float(length)};
}

/// The optical depth along the ray through a source's field, `s` being the scene of its volume.
[[nodiscard]] inline float depth_along(const WavefrontScene& s, const EmissionSource& source,
                                       const Ray& world, double distance, float time, int fewer,
                                       Rng& rng) {
  const auto line = line_through(source, world, distance, time);
  if (!line) return 0;
  return optical_depth(s.field, *line, {fewer_points(source.points, fewer), source.least}, rng);
}

/// Which places have light of a fire at collisions, by the bricks of its field.
HWY_INLINE M is_at_collisions(const FireAtCollisions& fire, I brick) {
  return mask(hn::Ne(as_int(gather(fire.holds().data(), brick)), splat_int(0)));
}

/// What a fire emits at chosen ones of these places, which are (x, y, z) in cells that `to_color`
/// takes to those of its colour's field.
HWY_INLINE V emission_at(const Emitter& fire, const SamplePlaces& places, const Affine& to_color,
                         F x, F y, F z, M on) {
  const F value = places.values(fire.field);
  const F color = fire.color_by ? values_at(*fire.color_by, to_color, x, y, z) : value;
  return emission_in_lanes(fire.fire, value, color, on);
}

/// What lines gather of a fire at a register of points in its cells.
HWY_INLINE V emission_on_line(const EmissionSource& source, F x, F y, F z, M on) {
  const SamplePlaces places(source.fire->field, Affine{}, x, y, z);
  const I brick = where(hn::And(on, places.inside), places.brick);
  M solid = mask(hn::Ne(brick, splat_int(int(kZeroBrick))));
  if (source.at_collisions) {
    solid = hn::AndNot(is_at_collisions(*source.at_collisions, brick), solid);
  }
  if (hn::AllFalse(kF, solid)) return {splat(0), splat(0), splat(0)};
  const V e = emission_at(*source.fire, places, source.cells_to_color, x, y, z, solid);
  const auto emits = [&](F v) { return hn::IfThenElseZero(solid, v); };
  return {emits(e.x), emits(e.y), emits(e.z)};
}

/// The integral of what a fire emits along a line, right on average.
HWY_NOINLINE Rgb emission_along(const EmissionSource& source, const Line& line, int fewer,
                                Rng& rng) {
  const SpreadPoints all(line, {fewer_points(source.points, fewer), 1}, rng);
  EvenSum sums[3];
  for (std::uint32_t k = 0; k < all.n; k += kLanes) {
    const F t = all.from(k);
    const auto along = [&](int axis) {
      return hn::MulAdd(splat(line.way[axis]), t, splat(line.from[axis]));
    };
    const V e = emission_on_line(source, along(0), along(1), along(2), first(all.n - k));
    sums[0].add(k, e.x), sums[1].add(k, e.y), sums[2].add(k, e.z);
  }
  return Rgb(sums[0].value(), sums[1].value(), sums[2].value()) * (line.length / float(all.n));
}

/// Of a path that was scattered the direction is what its light varies by: its lines have so many
/// times fewer points than those of the camera's rays (tests/bench/RESULTS.md, "Fires").
inline constexpr int kFewerWhereScattered = 8;

/// What emission_of asks of `along`, through the volumes of scenes, by number.
struct Along {
  std::span<const WavefrontScene> scenes;
  Rng& rng;
  int fewer = 1;  ///< so many times fewer points than sources have

  [[nodiscard]] Rgb operator()(const LineSources& lines, const Ray& ray, double distance,
                               float time) const {
    Rgb sum(0.0f);
    const float u = rng.uniform();
    lines.tree.visit(ray, distance, [&](std::uint32_t i, double limit) {
      const EmissionSource& source = lines.sources[i];
      const WavefrontScene& s = scenes[source.volume];
      if (source.is_even_medium() && has_lines(s.field, *source.field)) {
        sum += source.of_depth * depth_along(s, source, ray, distance, time, fewer, rng);
      } else if (source.in_lanes) {
        const auto line = line_through(source, ray, distance, time);
        if (line) sum += emission_along(source, *line, fewer, rng);
      } else {
        sum += integrate(source, ray, distance, time, u, fewer);
      }
      return limit;
    });
    return sum;
  }
};

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
