// What a picture is made of besides its volumes: camera, lights, surfaces and the options of the
// estimator.
// Plain values: scene files and tools fill them, `render` reads them.
#pragma once

#include <variant>
#include <vector>

#include "pvol/render/area_light.h"
#include "pvol/render/camera.h"
#include "pvol/render/options.h"
#include "pvol/render/point_light.h"
#include "pvol/render/sky.h"
#include "pvol/render/spot_light.h"
#include "pvol/render/sun.h"
#include "pvol/render/surface.h"

namespace pvol {

/// Lights besides the environment. To add one, see libpvol/SOURCES.md.
using Light = std::variant<Sun, PointLight, SpotLight, AreaLight>;

/// Throws Error, which says what is wrong, for values out of range.
void validate(const Light& light);

/// What surrounds volumes, and how they are rendered.
struct Scene {
  Camera camera;
  Environment environment = GradientSky{};
  std::vector<Light> lights;
  RenderOptions options;
  std::vector<Surface> surfaces{};
  friend bool operator==(const Scene&, const Scene&) = default;
};

}  // namespace pvol
