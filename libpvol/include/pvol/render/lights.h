// Lights of a scene made ready for sampling.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "pvol/math/box.h"
#include "pvol/math/direction.h"
#include "pvol/math/rng.h"
#include "pvol/render/light_sample.h"
#include "pvol/render/near_lights.h"
#include "pvol/render/scene.h"
#include "pvol/render/sky_light.h"

namespace pvol {

/// A sun with its constants. A disc below 7e-6 degrees, which float directions do not resolve, is a
/// delta sun too.
struct SunLight {
  Vec3f direction;  ///< unit, towards the sun
  Rgb irradiance;
  Rgb disc_radiance;               ///< 0 for a delta sun
  float one_minus_cos_radius = 0;  ///< of the disc; 0: delta
  float disc_pdf = 0;              ///< 1 / solid angle; 0: delta

  explicit SunLight(const Sun& sun);

  // Directions are unit.

  /// Radiance that a ray meets which has left everything in this direction.
  [[nodiscard]] Rgb seen(Vec3f d) const {
    return one_minus_cos(d, direction) < one_minus_cos_radius ? disc_radiance : Rgb(0.0f);
  }
  /// Density of `sample` where `seen` is not 0.
  [[nodiscard]] float pdf() const { return disc_pdf; }

  // The questions that every light answers.

  /// Light that arrives at where(), a place in the world.
  template <class Where>
  [[nodiscard]] LightSample sample(const Where&, Rng& rng) const {
    return disc_pdf == 0 ? LightSample{direction, irradiance} : sample_disc(rng);
  }
  /// Around the places where rays on their way may meet it, if these are not infinitely far.
  [[nodiscard]] static Box met_within() { return {}; }
  /// What a ray of unit direction meets of it before a distance.
  [[nodiscard]] static LightMet met(const Ray&, double) { return {}; }
  /// About the irradiance in a box of the world, on planes that face the light.
  [[nodiscard]] Rgb irradiance_on(const Box&) const { return irradiance; }
  /// Irradiance of a plane with this unit normal at a place, with nothing in between.
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;

 private:
  [[nodiscard]] LightSample sample_disc(Rng& rng) const;
};

/// The lights of a scene, ready for sampling: each a member of its own kind. To add one, see
/// libpvol/SOURCES.md.
using LightSource = std::variant<SunLight, PointSource, BallSource, SpotSource, AreaSource>;
[[nodiscard]] std::vector<LightSource> make_light_sources(std::span<const Light> lights);

}  // namespace pvol
