// Light on surfaces that nothing shades.
#pragma once

#include <numbers>
#include <variant>

#include "render/path/path_setup.h"

namespace pvol::detail {

/// What a white surface would scatter if nothing were in the way: what shadow catchers compare with
/// (THEORY.md, T5.18). Used by one thread.
class OpenLight {
 public:
  /// Of lights that have an open sky.
  [[nodiscard]] Rgb operator()(const LightSetup& light, const SurfaceHit& surface) {
    if (surface.normal != normal_) {
      normal_ = surface.normal;
      far_ = light.open_sky->irradiance(normal_);
      for (const LightSource& source : light.sources) {
        if (const auto* sun = std::get_if<SunLight>(&source)) far_ += sun->on_plane({}, normal_);
      }
    }
    Rgb sum = far_;
    for (const LightSource& source : light.sources) {
      if (std::holds_alternative<SunLight>(source)) continue;
      sum += std::visit([&](const auto& l) { return l.on_plane(surface.place, surface.normal); },
                        source);
    }
    return sum * float(1 / std::numbers::pi);
  }

 private:
  Vec3d normal_;  // of the surface that was asked for last: of planes there is but one
  Rgb far_;       // its irradiance by the sky and by suns
};

}  // namespace pvol::detail
