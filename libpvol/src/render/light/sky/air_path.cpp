#include "render/light/sky/air_path.h"

namespace pvol::detail {
namespace {

/// Integrates over one way through a shell, in parts in which densities are even.
void integrate(const Atmosphere& a, const AirRay& ray, double begin, AirStep& step) {
  constexpr int kParts = 8;
  const double length = (step.t - begin) / kParts;
  step.transmittance = Spectrum(1.0f);
  for (int i = 0; i < kParts; ++i) {
    const double u = (i + 0.5) / kParts;
    const Amounts n = ray.amounts(begin + (step.t - begin) * u);
    const Spectrum each = extinction(a, n);
    const Spectrum through = transmittance(each * float(length));
    Spectrum weight = step.transmittance;
    for (int b = 0; b < kBands; ++b) {
      const float x = each[b] * float(length);
      // (1 - exp(-x)) / x, by series where x is small.
      weight[b] *= float(length) * (x < 0.03f ? 1 - x * (0.5f - x / 6) : (1 - through[b]) / x);
    }
    const Spectrum molecules = weight * a.molecules * n.molecules;
    const Spectrum aerosols = weight * a.aerosols * (n.aerosols * a.aerosols_albedo);
    step.near.molecules.add(molecules, float(1 - u)), step.far.molecules.add(molecules, float(u));
    step.near.aerosols.add(aerosols, float(1 - u)), step.far.aerosols.add(aerosols, float(u));
    step.transmittance *= through;
  }
}

}  // namespace

AirPath make_path(const Atmosphere& a, int level, double cosine) {
  AirPath path;
  const AirRay ray(a, {level, 0, cosine, 1});
  path.grounded = ray.cross([&](int, int to, double t0, double t1) {
    integrate(a, ray, t0, path.steps.emplace_back(AirStep{.to = to, .t = t1}));
  });
  return path;
}

}  // namespace pvol::detail
