#include "pvol/volume/albedo_map.h"

#include <algorithm>

#include "pvol/error.h"

namespace pvol {
namespace {

float in_unit(float v) { return std::clamp(v, 0.0f, 1.0f); }

}  // namespace

std::optional<Misfit> misfit(const AlbedoMap& map) {
  for (const Ramp& ramp : map.colors.channels) {
    for (const RampPoint& p : ramp.points) {
      if (!(p.y >= 0 && p.y <= 1)) {
        return Misfit{{"colors"}, "colours in [0, 1], which multiply the albedo"};
      }
    }
  }
  return std::nullopt;
}

Rgb color_of(const AlbedoMap& map, float value) {
  const float mapped = value_at(map.map, value);
  if (map.colors.empty()) return Rgb(in_unit(mapped));
  const Rgb c = value_at(map.colors, mapped);
  return {in_unit(c.x), in_unit(c.y), in_unit(c.z)};
}

Rgb largest_color(const AlbedoMap& map, float most) {
  const ValueRange mapped = range_over(map.map, {0, most});
  if (map.colors.empty()) return Rgb(in_unit(mapped.hi));
  Rgb largest;
  for (int c = 0; c < 3; ++c) {
    largest[c] = in_unit(range_over(map.colors.channels[std::size_t(c)], mapped).hi);
  }
  return largest;
}

void validate(const AlbedoMap& map) {
  require_limits("albedo field", entries(map));
  if (const auto wrong = misfit(map)) {
    throw Error(std::string("albedo field: ") + wrong->keys.front() + ": expected " +
                wrong->expected);
  }
}

}  // namespace pvol
