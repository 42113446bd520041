// NumPy arrays in and out: strided views where nothing has to be converted, shapes that broadcast.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>
#include <string>
#include <vector>

#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "python/views.h"

namespace pvol::python {

namespace py = pybind11;

/// An array of doubles of any strides: the caller's own where it is of doubles, else a conversion.
using Doubles = py::array_t<double, py::array::forcecast>;
using Shape = std::vector<py::ssize_t>;

/// Points of an array (..., 3), and the leading shape. `array` keeps the data alive.
struct Points {
  Doubles array;
  Shape shape;
  Vectors views{};
};
/// Throws Error for another shape; `what` names the argument.
[[nodiscard]] Points points_of(const char* what, Doubles array);

/// Origins and directions (..., 3) and limits (...), broadcast against each other; the arrays keep
/// the data alive.
struct Rays {
  Points origins, directions;
  Doubles t_max;
  Shape shape;
  RayViews views{};
};
/// Throws Error for shapes that do not broadcast.
[[nodiscard]] Rays rays_of(const Doubles& origins, const Doubles& directions, const Doubles& t_max);

/// A new array of this shape, in C's order.
template <class T>
[[nodiscard]] py::array_t<T> new_array(const Shape& shape) {
  return py::array_t<T>(shape);
}

/// A copy of a vector of rows; T may be a structure that is known to NumPy.
template <class T>
[[nodiscard]] py::array_t<T> array_of(const std::vector<T>& rows) {
  py::array_t<T> array(py::ssize_t(rows.size()));
  if (!rows.empty()) std::memcpy(array.mutable_data(), rows.data(), rows.size() * sizeof(T));
  return array;
}

/// Scalars for an empty shape, as NumPy's own functions give them.
template <class T>
[[nodiscard]] py::object result_of(py::array_t<T> array) {
  if (array.ndim() == 0) return py::cast(*array.data());
  return array;
}

[[nodiscard]] Vec3d vector_of(const char* what, const Doubles& three);
[[nodiscard]] py::array_t<double> array_of(Vec3d v);
[[nodiscard]] py::array_t<double> array_of(const Box& box);  ///< (2, 3)
/// 4 x 4, for columns (i, j, k, 1): the last column is the shift.
[[nodiscard]] py::array_t<double> array_of(const Affine& map);
/// Of 3 x 4 or 4 x 4 numbers of that convention. Throws Error for others.
[[nodiscard]] Affine affine_of(const Doubles& matrix);

}  // namespace pvol::python
