// How bright UsdLux's lights are: https://openusd.org, "LightAPI", as clarified in 2024. A light's
// radiance is intensity x 2^exposure x colour; where it is normalised, over its area in the world,
// or over what stands for that of a DistantLight.
#include <cmath>

#include "pvol/volume/blackbody.h"
#include "usda/usda_light.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

constexpr float kWhiteKelvin = 6500;  // by definition white

/// Of luminance 1. USD has a table of black bodies, scaled so that 6500 K are white.
Vec3d color_of_temperature(double kelvin, ColorSpace space) {
  const Rgb hot = blackbody_color(float(kelvin)), white = blackbody_color(kWhiteKelvin);
  const Rgb color{hot.x / white.x, hot.y / white.y, hot.z / white.z};
  return conversion(ColorSpace::rec709, space).vector(Vec3d(color) / double(luminance(color)));
}

}  // namespace

Rgb emission_of(const UsdView& light, double size, ColorSpace space) {
  const double usual = light.prim().type == "DistantLight" ? 50000 : 1;
  double strength = input(light, "intensity", usual) * std::exp2(input(light, "exposure", 0));
  if (input(light, "normalize", 0) != 0 && size > 0) strength /= size;
  Vec3d color = light.vector(input_of(light, "color"), {1, 1, 1});
  const double kelvin = input(light, "colorTemperature", kWhiteKelvin);
  if (input(light, "enableColorTemperature", 0) != 0) {
    color = color * color_of_temperature(kelvin, space);
  }
  const Vec3d all = color * strength;
  if (!(min_component(all) >= 0) || !is_finite(Rgb(all))) {
    fail_at(light.where(), "a light that is negative or not finite", "numbers of at least 0");
  }
  return Rgb(all);
}

}  // namespace pvol::formats::detail
