#include "pvol/volume/fire.h"

#include "pvol/error.h"
#include "pvol/volume/blackbody.h"

namespace pvol {

std::optional<Misfit> misfit(const Fire& fire) {
  if (fire.kelvin && !fire.colors.empty()) {
    return Misfit{{"colors", "kelvin"}, "either the colour of a black body or a ramp of colours"};
  }
  if (fire.kelvin_of_intensity && !fire.kelvin) {
    return Misfit{{"kelvin_of_intensity"}, "kelvin beside it, which gives temperatures their unit"};
  }
  for (const Ramp& ramp : fire.colors.channels) {
    for (const RampPoint& p : ramp.points) {
      if (p.y < 0) return Misfit{{"colors"}, "colours of at least 0"};
    }
  }
  return std::nullopt;
}

Rgb emission(const Fire& fire, float value, float color_value) {
  Rgb e = fire.color * float(fire.intensity * double(value_at(fire.map, value)));
  if (fire.kelvin) {
    const double kelvin = *fire.kelvin * double(color_value);
    if (!(kelvin > 0)) return Rgb(0.0f);
    e *= blackbody_color(float(kelvin), fire.color_space);
    if (fire.kelvin_of_intensity) {
      const double ratio = kelvin / *fire.kelvin_of_intensity;
      e *= float(ratio * ratio * ratio * ratio);
    }
  } else if (!fire.colors.empty()) {
    e *= value_at(fire.colors, color_value);
  }
  return e;
}

void validate(const Fire& fire) {
  require_limits("fire", entries(fire));
  if (const auto wrong = misfit(fire)) {
    throw Error(std::string("fire: ") + wrong->keys.front() + ": expected " + wrong->expected);
  }
}

}  // namespace pvol
