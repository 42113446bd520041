#include "pvol/volume/medium.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pvol/error.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {
namespace {

// How far the sum of the shares may be off 1.
constexpr double kShareSlack = 1e-9;

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

}  // namespace

const char* expect_true(const Value& v) {
  return std::get<bool>(v.data) ? nullptr : "true, or another phase function instead";
}

Value to_value(const PhaseTable& table) {
  Value::List rows;
  for (const auto& [angle, value] : table.data->points) rows.push_back(Value::List{angle, value});
  return rows;
}

std::vector<PhaseTable::Point> phase_points(const Value& rows) {
  std::vector<PhaseTable::Point> points;
  for (const Value& row : *rows.list()) {
    if (!row.list()) return {};  // one point alone
    points.push_back({*(*row.list())[0].number(), *(*row.list())[1].number()});
  }
  return points;
}

const char* expect_phase_points(const Value& rows) {
  return expect_phase_table(phase_points(rows));
}

const char* expect_a_one(const Value& value) {
  Rgb color;
  assign(color, value);
  return max_component(color) == 1
             ? nullptr
             : "shares of which the largest is 1; scale with extinction instead";
}

void validate(const Medium& medium) {
  require(
      is_finite(medium.extinction_color) && max_component(medium.extinction_color) == 1 &&
          min_component(medium.extinction_color) >= 0,
      "the shares of the extinction by channel are out of range; expected numbers in [0, 1], of "
      "which the largest is 1");
  require(!medium.components.empty(), "the medium has no component; expected at least one");
  double sum = 0;
  for (const Component& c : medium.components) {
    require_limits("medium", entries(c));
    sum += c.share;
  }
  require(std::abs(sum - 1) <= kShareSlack,
          "the shares of the components sum up to " + std::to_string(sum) + ", expected 1");
}

bool share_rest(Medium& medium) {
  double left = 1;
  for (std::size_t i = 1; i < medium.components.size(); ++i) left -= medium.components[i].share;
  medium.components.front().share = std::max(0.0, left);
  return left >= -kShareSlack;
}

float largest_albedo(const Medium& medium) {
  float largest = 0;
  for (const Component& c : medium.components) {
    if (c.share > 0) largest = std::max(largest, max_component(c.albedo));
  }
  return largest;
}

bool emits(const Medium& medium) {
  return std::ranges::any_of(medium.components, [](const Component& c) {
    return c.share > 0 && max_component(c.emission) > 0;
  });
}

}  // namespace pvol
