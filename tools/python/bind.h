// What the module is made of, subject by subject.
#pragma once

#include <memory>

#include "python/arrays.h"
#include "python/cloud_volume.h"

namespace pvol::python {

using VolumeClass = py::class_<CloudVolume, std::shared_ptr<CloudVolume>>;

/// pvol.Volume and pvol.load.
[[nodiscard]] VolumeClass bind_volume(py::module_& m);
/// What is asked of points and rays.
void bind_rays(VolumeClass& volume);
/// Bounds: nodes, terminals, segments.
void bind_bounds(VolumeClass& volume);
/// pvol.Shell and pvol.fit_shell.
void bind_shells(py::module_& m, VolumeClass& volume);
/// pvol.render, pvol.Picture and pvol.read_picture.
void bind_pictures(py::module_& m);
/// pvol.Live.
void bind_live(py::module_& m);
/// pvol.compare and pvol.trade.
void bind_studies(py::module_& m);

}  // namespace pvol::python
