// Scenes as callers of Python give them: a path, a dict of sections, or volumes.
#pragma once

#include <pybind11/pybind11.h>

#include "python/pictures.h"

namespace pvol::python {

/// `settings` are options of the renderer by their keys, and sections as dicts; "count" and "force"
/// are taken as such. Throws Error.
[[nodiscard]] SceneRequest request_of(const pybind11::object& scene,
                                      const pybind11::kwargs& settings);

}  // namespace pvol::python
