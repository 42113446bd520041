#include "pvol/math/field_map.h"

#include <algorithm>
#include <cmath>

#include "pvol/math/field_map_keys.h"

namespace pvol {
namespace {

/// What comes before the power and the ramp.
float before_power(const FieldMap& map, float v) {
  double x = map.scale * double(v) + map.offset;
  if (map.clamp) x = std::clamp(x, (*map.clamp)[0], (*map.clamp)[1]);
  return float(x);
}

float after_power(const FieldMap& map, float x) {
  if (map.power == 1) return x;
  const auto y = double(std::max(x, 0.0f));
  if (map.power == 2) return float(y * y);  // in a tenth of the time
  if (map.power == 3) return float(y * y * y);
  return float(std::pow(y, map.power));
}

/// The rows of an array of two numbers, or of such arrays.
Value::List rows_of(const Value& value) {
  const Value::List& list = *value.list();
  return !list.empty() && list.front().list() ? list : Value::List{value};
}

}  // namespace

float value_at(const FieldMap& map, float v) {
  const float x = after_power(map, before_power(map, v));
  return std::max(map.ramp.points.empty() ? x : value_at(map.ramp, x), 0.0f);
}

ValueRange range_over(const FieldMap& map, ValueRange from) {
  // Look-ups leave the range of their samples by some ulp (T1.2), which a steep ramp magnifies.
  const float slack = map.ramp.points.empty() ? 0 : kRangeSlack;
  float a = before_power(map, from.lo - slack * std::abs(from.lo));
  float b = before_power(map, from.hi + slack * std::abs(from.hi));
  if (b < a) std::swap(a, b);
  ValueRange r{after_power(map, a), after_power(map, b)};
  if (map.power != 1) {
    r.lo *= 1 - kRangeSlack;
    r.hi *= 1 + kRangeSlack;
  }
  if (!map.ramp.points.empty()) r = range_over(map.ramp, r);
  return {std::max(r.lo, 0.0f), std::max(r.hi, 0.0f)};
}

const char* expect_ends(const Value& value) {
  const Value::List& list = *value.list();
  return *list[0].number() < *list[1].number() ? nullptr : "the smallest value, then the largest";
}

const char* expect_points(const Value& value) {
  std::optional<double> last;
  for (const Value& row : rows_of(value)) {
    const double x = *row.list()->front().number();
    if (last && !(*last < x)) return "points with ascending first numbers";
    last = x;
  }
  return nullptr;
}

Value clamp_value(const FieldMap& map) {
  return map.clamp ? Value(Value::List{(*map.clamp)[0], (*map.clamp)[1]}) : Value{};
}

void assign_clamp(FieldMap& map, const Value& value) {
  const Value::List& list = *value.list();
  map.clamp = {*list[0].number(), *list[1].number()};
}

Value ramp_value(const FieldMap& map) {
  if (map.ramp.points.empty()) return {};
  Value::List rows;
  for (const RampPoint& p : map.ramp.points) rows.emplace_back(Value::List{p.x, p.y});
  return rows;
}

void assign_ramp(FieldMap& map, const Value& value) {
  map.ramp.points.clear();
  for (const Value& row : rows_of(value)) {
    const Value::List& list = *row.list();
    map.ramp.points.push_back({float(*list[0].number()), float(*list[1].number())});
  }
}

}  // namespace pvol
