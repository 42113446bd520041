// Inputs of lights: inputs:intensity, or intensity in scenes before USD 21.02.
#pragma once

#include <utility>

#include "usda/usda_view.h"

namespace pvol::formats::detail {

[[nodiscard]] inline std::string input_of(const UsdView& light, const std::string& name) {
  const std::string input = "inputs:" + name;
  return light.find(input) == nullptr && light.find(name) != nullptr ? name : input;
}

[[nodiscard]] inline double input(const UsdView& light, const std::string& name, double otherwise) {
  return light.number(input_of(light, name), otherwise);
}

/// Marks what says no more than USD's own values, as exporters write it.
inline void ignore_usual(const UsdView& light) {
  const UsdView aside(light.prim(), light.frame());  // what it reads stays unused in `light`
  for (const auto& [name, usual] :
       {std::pair{"diffuse", 1.0}, {"specular", 1.0}, {"shaping:focus", 0.0}}) {
    if (input(aside, name, usual) == usual) light.ignore(input_of(aside, name));
  }
  if (input(aside, "shaping:focus", 0) == 0) light.ignore(input_of(aside, "shaping:focusTint"));
  for (const char* name : {"extent", "light:shaderId"}) light.ignore(name);
}

}  // namespace pvol::formats::detail
