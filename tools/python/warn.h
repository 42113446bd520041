// What is likely to be a mistake, told the way of Python.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace pvol::python {

/// A UserWarning for each sentence, at the place that called; throws where warnings are errors.
inline void warn(const std::vector<std::string>& sentences) {
  for (const std::string& s : sentences) {
    if (PyErr_WarnEx(PyExc_UserWarning, s.c_str(), 1) != 0) throw pybind11::error_already_set();
  }
}

}  // namespace pvol::python
