// pvol.Volume: what is asked of points and rays.
#include <pybind11/stl.h>

#include <limits>
#include <string>

#include "pvol/embed.h"
#include "python/bind.h"
#include "python/names.h"
#include "python/rays.h"

namespace pvol::python {
namespace {

constexpr std::size_t kFew = 4096;  // rays or points that are done before a thread has begun

/// NumPy columns of counts, and where they are.
struct Counted {
  py::dict arrays;
  CountColumns columns{};
};

Counted make_columns(const Shape& shape, bool wanted) {
  Counted c;
  if (!wanted) return c;
  const auto add = [&](const char* name, std::uint64_t*& to) {
    auto array = new_array<std::uint64_t>(shape);
    to = array.mutable_data();
    c.arrays[name] = std::move(array);
  };
  add("lookups", c.columns.lookups);
  add("bounds_tests", c.columns.bounds_tests);
  add("segments", c.columns.segments);
  add("null_collisions", c.columns.null_collisions);
  return c;
}

/// Calls work(numbers, stop) for arrays of the rays' shape; returns the array or, with counts, a
/// tuple of it and theirs.
template <class Work>
py::object for_rays(const Rays& rays, bool counts, const Work& work) {
  auto values = new_array<double>(rays.shape);
  Counted counted = make_columns(rays.shape, counts);
  const RayNumbers to{values.mutable_data(), counted.columns};
  if (rays.views.count() <= kFew) {
    const py::gil_scoped_release unlocked;
    work(to, Stop(false));
  } else {
    run_cancellable([&](const Stop& stop) { work(to, stop); });
  }
  py::object result = result_of(std::move(values));
  if (!counts) return result;
  return py::make_tuple(std::move(result), std::move(counted.arrays));
}

/// Whether rays go many at once: only one by one they are counted.
bool goes_at_once(const std::string& kernel, bool counts) {
  if (kernel == "scalar") return false;
  if (kernel == "auto") return !counts;
  throw Error("the kernel " + kernel + "; expected auto or scalar");
}

py::object flights(const CloudVolume& v, const Doubles& origins, const Doubles& directions,
                   const Doubles& t_max, std::uint64_t seed, const std::string& tracker,
                   bool counts, const std::string& kernel) {
  const auto how = named<Tracker>("tracker", tracker);
  const bool at_once = goes_at_once(kernel, counts) && how == Tracker::decomposition;
  const Rays rays = rays_of(origins, directions, t_max);
  return for_rays(rays, counts, [&](const RayNumbers& to, const Stop& stop) {
    if (at_once) {
      sample_flights_at_once(v.volume, v.batch_field(), rays.views, seed, to.value, stop);
    } else {
      sample_flights(v.volume, rays.views, how, seed, to, stop);
    }
  });
}

/// The library's names, and two shorter ones.
Transmittance estimator_of(const std::string& name) {
  if (name == "exact") return Transmittance::regular;
  if (name == "residual") return Transmittance::residual_ratio;
  return named<Transmittance>("estimator", name);
}

py::object transmittance(const CloudVolume& v, const Doubles& origins, const Doubles& directions,
                         const Doubles& t_max, std::uint64_t seed, const std::string& estimator,
                         bool counts, const std::string& kernel) {
  const Transmittance how = estimator_of(estimator);
  const bool at_once =
      goes_at_once(kernel, counts) && (how == Transmittance::ratio || how == Transmittance::analog);
  const Rays rays = rays_of(origins, directions, t_max);
  return for_rays(rays, counts, [&](const RayNumbers& to, const Stop& stop) {
    if (at_once) {
      sample_transmittances_at_once(v.volume, v.batch_field(), rays.views, how, seed, to.value,
                                    stop);
    } else {
      sample_transmittances(v.volume, rays.views, how, seed, to, stop);
    }
  });
}

py::object optical_depth(const CloudVolume& v, const Doubles& origins, const Doubles& directions,
                         const Doubles& t_max, bool counts) {
  const Rays rays = rays_of(origins, directions, t_max);
  return for_rays(rays, counts, [&](const RayNumbers& to, const Stop& stop) {
    find_optical_depths(v.volume, rays.views, to, stop);
  });
}

/// number(point) for each of the points.
template <class Number>
py::object for_points(const Doubles& array, const Number& number) {
  const Points points = points_of("points", array);
  auto values = new_array<float>(points.shape);
  float* to = values.mutable_data();
  const auto work = [&](const Stop& stop) {
    for_each_part(points.views.count, kPart, stop, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) to[i] = number(points.views[i]);
    });
  };
  if (points.views.count <= kFew) {
    const py::gil_scoped_release unlocked;
    work(false);
  } else {
    run_cancellable(work);
  }
  return result_of(std::move(values));
}

constexpr const char* kDensityText = R"(Density at points of the world, interpolated.

Parameters
----------
points : array (..., 3)
    World coordinates; doubles of any strides are read in place.

Returns
-------
float32 array (...)
    0 outside the volume.)";

constexpr const char* kExtinctionAtText = R"(Extinction mu_t at points of the world, per world unit.

As `density`, times the medium's extinction.)";

constexpr const char* kFlightsText =
    R"(Free flights: the distance to the next collision, of many rays.

The density of t is mu_t(t) exp(-int_0^t mu_t).

Parameters
----------
origins, directions : array (..., 3)
    Broadcast against each other; directions are normalised.
t_max : float or array (...)
    Length of the rays, in world units.
seed : int
    Ray i of a call has its own random numbers, from (seed, i): give each call another seed.
tracker : str
    "decomposition", "delta", "regular", "weighted-delta" or "weighted-decomposition"; all follow
    the same law, at different costs. Volumes with bounds that hold, as they do here, give weights
    of 1.
counts : bool
    Whether to return the work of each ray.
kernel : str
    "auto": with decomposition and without counts, many rays at once in the lanes of the
    processor's registers, in a third of the time. "scalar": one ray at a time, as with counts, with
    other random numbers, so that results differ by noise.

Returns
-------
float64 array (...)
    inf where there is no collision up to t_max. With counts a tuple of it and a dict of uint64
    arrays (...): "lookups" of the exact density (for "regular" cells crossed), "bounds_tests",
    "segments" entered and "null_collisions".)";

constexpr const char* kTransmittanceText = R"(Transmittance of many rays, estimated or exact.

Parameters
----------
origins, directions, t_max, seed, counts, kernel
    As in `flights`; "ratio" and "analog" go many at once.
estimator : str
    "ratio", "analog" (0 or 1), "residual" ("residual-ratio"), which are unbiased; "exact"
    ("regular"), for nearest and trilinear volumes; "auto", chosen for the volume.

Returns
-------
float64 array (...)
    With counts a tuple of it and a dict of arrays, as in `flights`.)";

constexpr const char* kOpticalDepthText = R"(Optical depth int mu_t dt of many rays, exact.

Cell by cell in closed form, for nearest and trilinear volumes. Parameters and results are those of
`flights`; "lookups" are cells crossed.)";

}  // namespace

void bind_rays(VolumeClass& volume) {
  const double endless = std::numeric_limits<double>::infinity();
  volume
      .def(
          "density",
          [](const CloudVolume& v, const Doubles& points) {
            return for_points(points, [&](Vec3d p) { return density_at(v.volume, p); });
          },
          py::arg("points"), kDensityText)
      .def(
          "extinction_at",
          [](const CloudVolume& v, const Doubles& points) {
            return for_points(points, [&](Vec3d p) { return extinction_at(v.volume, p); });
          },
          py::arg("points"), kExtinctionAtText)
      .def("flights", flights, py::arg("origins"), py::arg("directions"),
           py::arg("t_max") = endless, py::arg("seed") = 0, py::arg("tracker") = "decomposition",
           py::arg("counts") = false, py::arg("kernel") = "auto", kFlightsText)
      .def("transmittance", transmittance, py::arg("origins"), py::arg("directions"),
           py::arg("t_max") = endless, py::arg("seed") = 0, py::arg("estimator") = "ratio",
           py::arg("counts") = false, py::arg("kernel") = "auto", kTransmittanceText)
      .def("optical_depth", optical_depth, py::arg("origins"), py::arg("directions"),
           py::arg("t_max") = endless, py::arg("counts") = false, kOpticalDepthText);
}

}  // namespace pvol::python
