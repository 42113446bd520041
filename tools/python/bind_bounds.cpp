// pvol.Volume: its bounds, and how rays meet them.
#include <pybind11/stl.h>

#include <limits>
#include <optional>

#include "pvol/trackers.h"
#include "python/bind.h"
#include "python/bounds.h"

namespace pvol::python {
namespace {

struct SegmentRow {
  double t0, t1;
  float lo, hi;
};

py::array_t<BoundRow> bounds(const CloudVolume& v, std::optional<std::int64_t> level) {
  if (!level) return array_of(terminals_of(v.volume.density.octree));
  return array_of(nodes_of(v.cloud->pyramid, *level, double(v.volume.density.scale)));
}

py::array_t<SegmentRow> segments(const CloudVolume& v, const Doubles& origin,
                                 const Doubles& direction, double t_max) {
  std::vector<SegmentRow> rows;
  const Ray ray{vector_of("origin", origin), vector_of("direction", direction)};
  if (auto walk = enter(v.volume, ray, t_max)) {
    while (const auto s = walk->next()) rows.push_back({s->t0, s->t1, s->lo, s->hi});
  }
  return array_of(rows);
}

constexpr const char* kBoundsText = R"(Bounds on the extinction, cube by cube.

Parameters
----------
level : int, optional
    Of the pyramid: 0 has nodes of 8^3 cells, each further one of twice the edge, up to
    `levels` - 1, the root. Default: the cubes at which walks stop.

Returns
-------
structured array
    "lo" (three int64, the low corner in index space), "edge" (in cells), "minorant" and "majorant"
    (float64, of mu_t per world unit). Outside the cubes the density is 0.)";

constexpr const char* kSegmentsText = R"(The pieces of a ray with constant bounds.

Parameters
----------
origin, direction : three floats
t_max : float

Returns
-------
structured array
    "t0", "t1" (float64, world units from the origin), "lo", "hi" (float32): lo <= mu_t <= hi, hi > 0.
    In order and apart; between them mu_t is 0.)";

}  // namespace

void bind_bounds(VolumeClass& volume) {
  PYBIND11_NUMPY_DTYPE(BoundRow, lo, edge, minorant, majorant);
  PYBIND11_NUMPY_DTYPE(SegmentRow, t0, t1, lo, hi);
  volume.def("bounds", &bounds, py::arg("level") = py::none(), kBoundsText)
      .def("segments", &segments, py::arg("origin"), py::arg("direction"),
           py::arg("t_max") = std::numeric_limits<double>::infinity(), kSegmentsText);
}

}  // namespace pvol::python
