#include "python/toml_words.h"

#include <cmath>
#include <cstdio>

#include "pvol/error.h"
#include "pvol/math/value.h"

namespace pvol::python {
namespace {

namespace py = pybind11;

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", unsigned(c));
      out += code;
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// A TOML float, which has a point or an exponent.
std::string float_text(double v) {
  if (std::isnan(v)) return "nan";
  if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
  std::string text = number_text(v);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string table_text(const py::dict& table) {
  std::string text;
  for (const auto& [key, value] : table) {
    if (value.is_none()) continue;
    text += (text.empty() ? "" : ", ") + quoted(py::str(key)) + " = " + toml_text(value);
  }
  return "{" + text + "}";
}

std::string array_text(const py::sequence& items) {
  std::string text;
  for (const py::handle item : items) text += (text.empty() ? "" : ", ") + toml_text(item);
  return "[" + text + "]";
}

}  // namespace

std::string type_name(py::handle value) { return py::str(py::type::of(value).attr("__name__")); }

std::string toml_text(py::handle value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::int_>(value)) return py::str(value);
  if (py::isinstance<py::float_>(value)) return float_text(value.cast<double>());
  if (py::isinstance<py::str>(value)) return quoted(value.cast<std::string>());
  if (py::isinstance<py::dict>(value)) return table_text(value.cast<py::dict>());
  if (py::hasattr(value, "__fspath__")) return quoted(py::str(value.attr("__fspath__")()));
  if (py::hasattr(value, "tolist")) return toml_text(value.attr("tolist")());  // NumPy's
  if (py::isinstance<py::sequence>(value)) return array_text(value.cast<py::sequence>());
  throw Error("found a value of type " + type_name(value) +
              "; expected a number, a word, a sequence or a dict of these");
}

void add_words(const std::string& prefix, const py::dict& settings, Words& to) {
  for (const auto& [key, value] : settings) {
    const std::string name = prefix + std::string(py::str(key));
    if (value.is_none()) {
      to.erase(name);
    } else if (py::isinstance<py::dict>(value)) {
      add_words(name + ".", value.cast<py::dict>(), to);
    } else {
      to[name] = toml_text(value);
    }
  }
}

}  // namespace pvol::python
