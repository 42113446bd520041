// Python's values in the syntax of scene files, through which they are checked like those.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "python/words.h"

namespace pvol::python {

/// Of a value's type, for messages.
[[nodiscard]] std::string type_name(pybind11::handle value);

/// A value as TOML: numbers, words, paths, sequences and arrays, dicts as inline tables. Throws
/// Error for anything else.
[[nodiscard]] std::string toml_text(pybind11::handle value);

/// Adds the settings of a dict under names with a prefix ("medium."), those of dicts within under
/// further ones; a None takes one away.
void add_words(const std::string& prefix, const pybind11::dict& settings, Words& to);

}  // namespace pvol::python
