// pvol.Volume: how it is made, and what it is.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "pvol/error.h"
#include "pvol/volume/facts.h"
#include "python/bind.h"
#include "python/cancellable.h"
#include "python/names.h"
#include "python/toml_words.h"
#include "python/warn.h"

namespace pvol::python {
namespace {

/// Options of the renderer that volumes are made with; all other settings are the medium's.
constexpr std::array<std::string_view, 5> kOptions = {"interpolation", "depth", "micro_bounds",
                                                      "homogenise", "majorant_scale"};

Making making_of(const py::kwargs& settings) {
  py::dict medium, options;
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    const bool option = std::ranges::find(kOptions, name) != kOptions.end();
    (option ? options : medium)[key] = value;
  }
  Making how;
  add_words("medium.", medium, how.medium);
  add_words("render.", options, how.options);
  return how;
}

Affine map_of(const py::object& voxel_size, const py::object& index_to_world) {
  if (!index_to_world.is_none()) {
    if (voxel_size.is_none()) return affine_of(index_to_world.cast<Doubles>());
    throw Error("voxel_size and index_to_world exclude each other");
  }
  if (voxel_size.is_none()) return {};
  const auto size = voxel_size.cast<Doubles>();
  return scaling(size.ndim() == 0 ? Vec3d(*size.data()) : vector_of("voxel_size", size));
}

/// The array as one of single precision: itself, whatever its strides, where that is what it holds.
py::array_t<float> samples_of(const py::array& array) {
  const char kind = array.dtype().kind();
  if (array.ndim() != 3 || std::string_view("fiu").find(kind) == std::string_view::npos) {
    throw Error("an array of " + std::to_string(array.ndim()) + " axes and dtype " +
                std::string(py::str(array.dtype())) +
                "; expected the samples of a lattice: three axes of real numbers");
  }
  if (py::isinstance(array, py::module_::import("numpy").attr("ma").attr("MaskedArray"))) {
    throw Error("the array is masked; expected one without a mask, such as array.filled(0)");
  }
  auto samples = py::array_t<float, py::array::forcecast>::ensure(array);
  if (!samples) throw py::error_already_set();
  for (int axis = 0; axis < 3; ++axis) {
    if (samples.strides(axis) % py::ssize_t(sizeof(float)) != 0) {  // within records
      return py::array_t<float, py::array::c_style | py::array::forcecast>(samples.attr("copy")());
    }
  }
  return samples;
}

DenseArray dense(const py::array_t<float>& samples) {
  DenseArray d;
  d.values = samples.data();
  Vec3l stride;
  for (int axis = 0; axis < 3; ++axis) {
    constexpr py::ssize_t kMost = std::numeric_limits<std::int32_t>::max();
    d.size[axis] = std::int32_t(std::min(samples.shape(axis), kMost));
    stride[axis] = samples.strides(axis) / py::ssize_t(sizeof(float));
  }
  d.stride = stride;
  return d;
}

CloudVolume make(const py::object& array, const py::object& voxel_size,
                 const py::object& index_to_world, const std::string& name,
                 const py::kwargs& settings) {
  if (!py::isinstance<py::array>(array)) {
    throw py::type_error("found a " + type_name(array) +
                         ", expected a NumPy array of three axes (numpy.asarray makes one), or "
                         "pvol.load(file)");
  }
  const Making how = making_of(settings);
  const Affine map = map_of(voxel_size, index_to_world);
  const py::array_t<float> samples = samples_of(py::array(array));
  const DenseArray lattice = dense(samples);
  return cancellable([&](const Stop&) {
    const LookUp look_up = read_making(name, how).scene.options.look_up;
    VoxelGrid grid = make_grid(lattice, map);
    return make_cloud_volume(bound_grid(std::move(grid), look_up), name, how, false);
  });
}

CloudVolume load(const std::filesystem::path& file, const py::object& grid,
                 const py::kwargs& settings) {
  const Making how = making_of(settings);
  formats::GridOptions options;
  if (!grid.is_none()) options.grid = grid.cast<std::string>();
  CloudVolume v = cancellable([&](const Stop&) {
    const LookUp look_up = read_making(file, how).scene.options.look_up;
    auto cloud =
        std::make_shared<const formats::Cloud>(formats::load_cloud(file, options, look_up));
    return make_cloud_volume(std::move(cloud), file, how, true);
  });
  warn(v.cloud->report.warnings);
  return v;
}

CloudVolume changed(const CloudVolume& v, const py::kwargs& settings) {
  Words medium = v.medium;
  add_words("medium.", settings, medium);
  return cancellable([&](const Stop&) { return with_medium(v, medium); });
}

CloudVolume remade(const CloudVolume& v, const py::kwargs& settings) {
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    if (std::ranges::find(kOptions, name) != kOptions.end()) continue;
    throw Error("there is no option '" + name + "'; expected " +
                listed({kOptions.begin(), kOptions.end()}));
  }
  Words options = v.making;
  add_words("render.", settings, options);
  return cancellable([&](const Stop&) { return with_options(v, options); });
}

std::string repr_of_volume(const CloudVolume& v) {
  const Vec3d size =
      v.volume.density.world_box.empty() ? Vec3d{} : v.volume.density.world_box.extent();
  const VolumeField& f = v.volume.density;
  return "<pvol.Volume '" + v.given.file.string() + "': " + number_text(float(size.x)) + " x " +
         number_text(float(size.y)) + " x " + number_text(float(size.z)) +
         " world units, extinction " + number_text(float(v.volume.medium.extinction)) + ", " +
         name(f.look_up) + ", octree depth " + std::to_string(f.octree.depth) + ">";
}

py::array_t<std::int64_t> support_box(const CloudVolume& v) {
  const Pyramid& p = v.cloud->pyramid;
  py::array_t<std::int64_t> box({2, 3});
  for (int k = 0; k < 3; ++k) {
    box.mutable_at(0, k) = p.empty() ? 0 : p.support_lo[k];
    box.mutable_at(1, k) = p.empty() ? 0 : p.support_hi[k];
  }
  return box;
}

py::tuple cells_along(const CloudVolume& v) {
  const Pyramid& p = v.cloud->pyramid;
  const Vec3l size = p.empty() ? Vec3l{} : p.support_hi - p.support_lo;
  return py::make_tuple(size.x, size.y, size.z);
}

py::dict bytes_of(const CloudVolume& v) {
  py::dict bytes;
  bytes["samples"] = v.volume.density.value_bytes();
  bytes["octree"] = v.volume.density.octree.bytes();
  bytes["micro_bounds"] = v.volume.density.squeeze_bytes();
  return bytes;
}

py::array_t<double> albedo_of(const CloudVolume& v) {
  const Rgb a = v.volume.medium.components.front().albedo;
  return array_of(Vec3d(double(a.x), double(a.y), double(a.z)));
}

constexpr const char* kVolumeText = R"(A density with bounds, ready for rays. It never changes.

Parameters
----------
array : array (nx, ny, nz)
    Samples of the density, not negative: that of lattice point (i, j, k) is array[i, j, k]. float32
    of any strides is read where it is, other real numbers are converted. The volume keeps a sparse
    copy, so that the array may change or go.
voxel_size : float or three, optional
    World units between samples. Default 1.
index_to_world : array (4, 4) or (3, 4), optional
    Instead: the map of columns (i, j, k, 1) to the world; the shift is the last column.
name : str
    For messages.
extinction : float
    Per world unit and unit of density: mu_t = extinction * density. Default 1.
albedo : float or three
    Scattered share, by channel. Default 0.999.
g : float
    Mean cosine of Henyey-Greenstein. Default 0.5.
interpolation : str
    "trilinear" (default), "nearest" or "tricubic".
depth : int, optional
    Deepest level of the octree at which walks stop, 0 (the root) to 23; above it, and without, they
    stop where that costs least.
micro_bounds, homogenise, majorant_scale
    As the options of the renderer.
**medium
    All other keys of a scene's [medium]: emission, other phase functions, placement, ...)";

constexpr const char* kLoadText = R"(Reads a cloud: .pvol, .vdb, .nvdb, or a recipe (.toml).

Parameters
----------
path : path
grid : str, optional
    Name of the density's grid. Default "density", else the only one.
**settings
    As for `Volume`. Without an extinction, one is chosen that makes the cloud 40 mean free paths
    thick along its thickest axis. Recipes also support "procedural" interpolation.

Returns
-------
Volume)";

constexpr const char* kWithMediumText = R"(The same density with another medium.

Takes the settings of a medium (see `Volume`); those that are not named stay, a None restores the
default. Changing albedo, phase or emission costs nothing; another extinction rebuilds octree and
samples.)";

constexpr const char* kWithOptionsText = R"(The same density and medium, made with other options.

depth, micro_bounds, homogenise, majorant_scale and, as far as the bounds hold for it, interpolation;
those that are not named stay, a None restores the default.)";

}  // namespace

VolumeClass bind_volume(py::module_& m) {
  VolumeClass volume(m, "Volume", kVolumeText);
  volume
      .def(py::init(&make), py::arg("array"), py::arg("voxel_size") = py::none(),
           py::arg("index_to_world") = py::none(), py::arg("name") = "array")
      .def("with_medium", &changed, kWithMediumText)
      .def("with_options", &remade, kWithOptionsText)
      .def("__repr__", &repr_of_volume)
      .def_property_readonly(
          "name", [](const CloudVolume& v) { return v.given.file.string(); },
          "For messages; of files their path.")
      .def_property_readonly("support", &support_box,
                             "Box of cells with density above 0, (2, 3): [lo, hi) in index space.")
      .def_property_readonly("shape", &cells_along, "Cells along each axis of that box.")
      .def_property_readonly(
          "world_box", [](const CloudVolume& v) { return array_of(v.volume.density.world_box); },
          "Box around the density in the world, (2, 3); lo > hi where there is none.")
      .def_property_readonly(
          "index_to_world", [](const CloudVolume& v) { return array_of(index_to_world(v)); },
          "The map of columns (i, j, k, 1), (4, 4).")
      .def_property_readonly(
          "extinction", [](const CloudVolume& v) { return v.volume.medium.extinction; },
          "Per world unit and unit of density.")
      .def_property_readonly("albedo", &albedo_of, "By channel, of the first component.")
      .def_property_readonly(
          "interpolation", [](const CloudVolume& v) { return name(v.volume.density.look_up); },
          "How the density at a point is interpolated.")
      .def_property_readonly(
          "depth", [](const CloudVolume& v) { return v.volume.density.octree.depth; },
          "Deepest level of the octree at which walks stop; 0 is the root. The volume made with "
          "this depth has the same bounds.")
      .def_property_readonly(
          "levels", [](const CloudVolume& v) { return v.cloud->pyramid.levels.size(); },
          "Levels of the pyramid of bounds; 0 has nodes of 8^3 cells, the last the root.")
      .def_property_readonly("bytes", &bytes_of, "Size of its parts in memory, in bytes.");
  m.def("load", &load, py::arg("path"), py::arg("grid") = py::none(), kLoadText);
  return volume;
}

}  // namespace pvol::python
