#include "pvol/math/color_ramp.h"

namespace pvol {

Value to_value(const ColorRamp& ramp) {
  if (ramp.empty()) return {};
  const auto& c = ramp.channels;
  Value::List rows;
  for (std::size_t i = 0; i < c[0].points.size(); ++i) {
    rows.emplace_back(
        Value::List{c[0].points[i].x, c[0].points[i].y, c[1].points[i].y, c[2].points[i].y});
  }
  return rows;
}

void assign(ColorRamp& ramp, const Value& value) {
  ramp = {};
  const Value::List& list = *value.list();
  const bool rows = list.front().list() != nullptr;
  for (const Value& row : rows ? list : Value::List{value}) {
    const auto at = [&](std::size_t i) { return float(*(*row.list())[i].number()); };
    for (std::size_t c = 0; c < 3; ++c) ramp.channels[c].points.push_back({at(0), at(c + 1)});
  }
}

}  // namespace pvol
