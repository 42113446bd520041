// Python's values in the syntax of scene files, through which they are checked like those.
#pragma once

#include <pybind11/pybind11.h>

#include <map>
#include <string>
#include <vector>

namespace pvol::python {

/// Settings by name: "medium.g" -> "0.5".
using Words = std::map<std::string, std::string>;

/// A value as TOML: numbers, words, paths, sequences and arrays, dicts as inline tables. Throws
/// Error for anything else.
[[nodiscard]] std::string toml_text(pybind11::handle value);

/// Adds the settings of a dict under names with a prefix ("medium."), those of dicts within under
/// further ones; a None takes one away.
void add_words(const std::string& prefix, const pybind11::dict& settings, Words& to);

/// "medium.g=0.5", as formats::read_scene takes them.
[[nodiscard]] std::vector<std::string> sets_of(const Words& words);

}  // namespace pvol::python
