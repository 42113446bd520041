// What lights may be.
#include <cmath>
#include <string>

#include "pvol/error.h"
#include "pvol/render/lights.h"

namespace pvol {
namespace {

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

/// Finite and not zero, also squared.
bool is_direction(Vec3d d) { return std::isfinite(length(d)) && length(d) > 0; }

bool is_light(Rgb c) { return is_finite(c) && min_component(c) >= 0; }

void validate(const Sun& s) {
  require(is_direction(s.direction), "sun: the direction must be finite and not zero");
  require(s.angle == 0 || (s.angle >= 0.01 && s.angle < 180),
          "sun: the angle must be 0 or lie in [0.01, 180) degrees");
  require(is_light(s.irradiance), "sun: the irradiance must be finite and not negative");
}

}  // namespace

void validate(const Environment& environment) {
  const char* const kRadiance = "sky: every radiance must be finite and not negative";
  if (const auto* s = std::get_if<ConstantSky>(&environment)) {
    require(is_light(s->radiance), kRadiance);
  } else if (const auto* g = std::get_if<GradientSky>(&environment)) {
    require(is_light(g->zenith) && is_light(g->horizon) && is_light(g->ground), kRadiance);
    require(is_direction(g->up), "sky: up must be finite and not zero");
  } else if (const auto* p = std::get_if<ImageSky>(&environment)) {
    require(p->width > 0 && p->height > 0 &&
                p->pixels.size() == std::size_t(p->width) * std::size_t(p->height),
            "sky: the picture must have width x height pixels");
    require(std::isfinite(p->rotation), "sky: the rotation must be finite");
    for (const Rgb pixel : p->pixels) {
      require(is_light(pixel) && is_light(pixel * p->scale), kRadiance);
    }
  }
}

void validate(const Light& light) {
  std::visit([](const auto& l) { validate(l); }, light);
}

}  // namespace pvol
