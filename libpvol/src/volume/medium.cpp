#include "pvol/volume/medium.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pvol/error.h"

namespace pvol {
namespace {

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

void validate(const Component& c) {
  require(c.share >= 0 && c.share <= 1, "the share of a component must lie in [0, 1]");
  require(is_finite(c.albedo) && min_component(c.albedo) >= 0 && max_component(c.albedo) <= 1,
          "albedo must lie in [0, 1] in every channel");
  require(is_finite(c.emission) && min_component(c.emission) >= 0,
          "emission must be finite and not negative");
  validate(c.phase);
}

}  // namespace

void validate(const Medium& medium) {
  require(!medium.components.empty(), "a medium needs at least one component");
  double sum = 0;
  for (const Component& c : medium.components) {
    validate(c);
    sum += c.share;
  }
  require(std::abs(sum - 1) <= kShareSlack,
          "the shares of components sum up to " + std::to_string(sum) + ", expected 1");
}

float largest_albedo(const Medium& medium) {
  float largest = 0;
  for (const Component& c : medium.components) {
    if (c.share > 0) largest = std::max(largest, max_component(c.albedo));
  }
  return largest;
}

}  // namespace pvol
