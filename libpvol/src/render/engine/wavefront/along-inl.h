// Emission and optical depths along lines: of even media in lanes, of the rest line by line
// (THEORY.md, T5.11).

#if defined(PVOL_LANE_ALONG_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_ALONG_INL_H
#undef PVOL_LANE_ALONG_INL_H
#else
#define PVOL_LANE_ALONG_INL_H
#endif

#include "render/engine/wavefront/wavefront_scene.h"
#include "volume/simd/lines-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// The optical depth of a ray of the world up to a distance through a source's field, `s` being the
/// scene of its volume.
[[nodiscard]] inline float depth_along(const WavefrontScene& s, const EmissionSource& source,
                                       const Ray& world, double distance, float time, int fewer,
                                       Rng& rng) {
  const VolumeField& field = *source.field;
  const Affine to_first = source.to_first_at(time);
  const Vec3d from = field.world_to_cells.point(to_first.point(world.o));
  const Vec3d step = field.world_to_cells.vector(to_first.vector(world.d));
  const auto span = intersect(field.octree.support(), {from, step}, 0, distance);
  if (!span) return 0;
  const double length = span->t1 - span->t0;
  const Line line{Vec3f(from + step * span->t0 + Vec3d(DenseBounds::kBorder)), Vec3f(step * length),
                  float(length)};
  return optical_depth(s.field, line, {fewer_points(source.points, fewer), source.least}, rng);
}

/// Of a path that was scattered the direction is what its light varies by: its lines have so many
/// times fewer points than those of the camera's rays (tests/bench/RESULTS.md, "Fires").
inline constexpr int kFewerWhereScattered = 4;

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
