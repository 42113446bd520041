#include "render/plan/forecast.h"

#include "pvol/bounds/octree.h"
#include "render/path/path_setup.h"

namespace pvol::detail {
namespace {

constexpr double kSample = 200;   // ns besides collisions
constexpr double kSurface = 700;  // ns of a hit, with its shadow rays

/// Seconds of a collision among these, with the flight before it and the shadow rays from it.
[[nodiscard]] double seconds_per_collision(const Counts& c) {
  constexpr double kScattering = 150;  // ns besides flights
  if (c.collisions == 0) return 0;
  const double flights = nanoseconds(c.path, c.collisions) + nanoseconds(c.shadow, c.shadow_rays);
  return 1e-9 * (kScattering + flights / double(c.collisions));
}

}  // namespace

double nanoseconds(const Tally& t, std::uint64_t flights) {
  const WalkCosts costs;
  return costs.segment * double(t.segments) +
         costs.tentative * double(t.null_collisions + flights) + costs.lookup * double(t.lookups);
}

double seconds_of(const Counts& counts, int paths) {
  return 1e-9 * (kSample * paths + kSurface * double(counts.surface_hits)) +
         double(counts.collisions) * seconds_per_collision(counts);
}

double share_of_time(KernelKind kernel) {
  switch (kernel) {
    case KernelKind::avx512:
      return 0.22;
    case KernelKind::avx2:
      return 0.28;
    case KernelKind::sse4:
    case KernelKind::neon:
      return 0.45;
    default:
      return 1;
  }
}

Forecast forecast(const RenderPlan& plan, const CameraProbe& probe) {
  const ImagePart part = image_part(plan.scene.options);
  Forecast f;
  f.samples = double(part.width) * part.height * samples_of_part(plan.scene.options);
  f.collisions = f.samples * probe.collisions();
  return f;
}

}  // namespace pvol::detail
