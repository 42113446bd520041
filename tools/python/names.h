// Words that callers give for enumerations of the library.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pvol/error.h"
#include "pvol/math/names.h"
#include "pvol/math/value.h"

namespace pvol::python {

/// The enumerator of a name. Throws Error that lists all names.
template <HasNames Enum>
[[nodiscard]] Enum named(const char* what, std::string_view word) {
  if (const auto found = find_named<Enum>(word)) return *found;
  std::vector<std::string> all;
  for (const Named<Enum>& n : names(Enum{})) all.emplace_back(n.name);
  throw Error(std::string(what) + ": found '" + std::string(word) + "', expected " + listed(all));
}

}  // namespace pvol::python
