// Inputs of lights: inputs:intensity, or intensity in scenes before USD 21.02.
#pragma once

#include "usda/usda_view.h"

namespace pvol::formats::detail {

[[nodiscard]] inline std::string input_of(const UsdView& light, const std::string& name) {
  const std::string input = "inputs:" + name;
  return light.find(input) == nullptr && light.find(name) != nullptr ? name : input;
}

[[nodiscard]] inline double input(const UsdView& light, const std::string& name, double otherwise) {
  return light.number(input_of(light, name), otherwise);
}

}  // namespace pvol::formats::detail
