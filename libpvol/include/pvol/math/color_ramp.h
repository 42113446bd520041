// Colours that go by one number.
#pragma once

#include <array>

#include "pvol/math/ramp.h"
#include "pvol/math/value.h"
#include "pvol/math/vec.h"

namespace pvol {

/// Colours along a field's values, channel by channel; none without points.
struct ColorRamp {
  std::array<Ramp, 3> channels{};
  friend bool operator==(const ColorRamp&, const ColorRamp&) = default;

  [[nodiscard]] bool empty() const { return channels[0].points.empty(); }
};

/// Of any x that is no NaN.
[[nodiscard]] inline Rgb value_at(const ColorRamp& ramp, float x) {
  return {value_at(ramp.channels[0], x), value_at(ramp.channels[1], x),
          value_at(ramp.channels[2], x)};
}

/// As rows X,R,G,B; nothing without points.
[[nodiscard]] Value to_value(const ColorRamp& ramp);
/// Of a row of four numbers, or of such rows.
void assign(ColorRamp& ramp, const Value& value);

}  // namespace pvol
