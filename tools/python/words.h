// Settings in the syntax of scene files, through which they are checked like those.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace pvol::python {

/// Settings by name: "medium.g" -> "0.5".
using Words = std::map<std::string, std::string>;

/// "medium.g=0.5", as formats::read_scene takes them.
[[nodiscard]] inline std::vector<std::string> sets_of(const Words& words) {
  std::vector<std::string> sets;
  for (const auto& [name, text] : words) sets.push_back(name + "=" + text);
  return sets;
}

}  // namespace pvol::python
