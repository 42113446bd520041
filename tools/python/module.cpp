// The extension behind the package pvol: see pvol/__init__.py.
#include <exception>
#include <string>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/version.h"
#include "python/bind.h"

namespace pvol::python {
namespace {

/// Messages about settings are those of command lines, whose --set nobody wrote here.
std::string without_set(std::string text) {
  constexpr std::string_view kSet = "--set ";
  if (text.starts_with(kSet)) text.erase(0, kSet.size());
  return text;
}

/// pvol.Error for what the library throws.
void bind_error(py::module_& m) {
  static py::exception<Error> error(m, "Error", PyExc_ValueError);
  error.attr("__doc__") = "Bad input: what was found, what was expected, and a remedy.";
  py::register_exception_translator([](std::exception_ptr p) {
    try {
      if (p) std::rethrow_exception(p);
    } catch (const Error& e) {
      error(without_set(e.what()).c_str());
    } catch (const cli::UsageError& e) {
      error(without_set(e.what()).c_str());
    }
  });
}

}  // namespace
}  // namespace pvol::python

PYBIND11_MODULE(_pvol, m) {
  using namespace pvol::python;
  m.attr("__version__") = PVOL_VERSION;
  bind_error(m);
  VolumeClass volume = bind_volume(m);
  bind_rays(volume);
  bind_bounds(volume);
  bind_shells(m, volume);
  bind_pictures(m);
  bind_live(m);
  bind_studies(m);
}
