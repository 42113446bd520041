#include "python/arrays.h"

#include <pybind11/stl.h>

#include "pvol/error.h"

namespace pvol::python {
namespace {

Shape shape_of(const py::array& a) { return {a.shape(), a.shape() + a.ndim()}; }

std::string text_of(const Shape& shape) {
  std::string text = "(";
  for (const py::ssize_t n : shape) text += (text.size() > 1 ? ", " : "") + std::to_string(n);
  return text + (shape.size() == 1 ? ",)" : ")");
}

/// The array as one of rows, (N, 3) or (N,): a view where the strides allow it.
Doubles flat(const Doubles& array, std::size_t row_axes) {
  const std::size_t axes = std::size_t(array.ndim());
  if (axes == row_axes + 1) return array;
  Shape rows{1};
  for (std::size_t k = 0; k + row_axes < axes; ++k) rows[0] *= array.shape(py::ssize_t(k));
  if (row_axes == 1) rows.push_back(3);
  return array.attr("reshape")(rows).cast<Doubles>();
}

Vectors vectors_of(const Doubles& rows) {
  return {reinterpret_cast<const char*>(rows.data()), rows.strides(0), rows.strides(1),
          std::size_t(rows.shape(0))};
}

Doubles broadcast(const Doubles& array, const Shape& shape) {
  return py::module_::import("numpy").attr("broadcast_to")(array, shape).cast<Doubles>();
}

/// The shape that several broadcast to. Throws Error where there is none.
Shape joined(const Shape& a, const Shape& b, const Shape& c) {
  try {
    return py::module_::import("numpy")
        .attr("broadcast_shapes")(py::tuple(py::cast(a)), py::tuple(py::cast(b)),
                                  py::tuple(py::cast(c)))
        .cast<Shape>();
  } catch (const py::error_already_set&) {
    throw Error("origins of " + text_of(a) + " rays, directions of " + text_of(b) +
                " and t_max of " + text_of(c) + " cannot be broadcast against each other");
  }
}

Shape leading_shape(const char* what, const Doubles& array) {
  Shape shape = shape_of(array);
  if (shape.empty() || shape.back() != 3) {
    throw Error(std::string(what) + " have the shape " + text_of(shape) +
                "; expected (..., 3), with the components of a vector last");
  }
  shape.pop_back();
  return shape;
}

Shape with_components(Shape shape) {
  shape.push_back(3);
  return shape;
}

}  // namespace

Points points_of(const char* what, Doubles array) {
  Points p;
  p.shape = leading_shape(what, array);
  p.array = flat(array, 1);
  p.views = vectors_of(p.array);
  return p;
}

Rays rays_of(const Doubles& origins, const Doubles& directions, const Doubles& t_max) {
  Rays r;
  r.shape = joined(leading_shape("origins", origins), leading_shape("directions", directions),
                   shape_of(t_max));
  r.origins = points_of("origins", broadcast(origins, with_components(r.shape)));
  r.directions = points_of("directions", broadcast(directions, with_components(r.shape)));
  r.t_max = flat(broadcast(t_max, r.shape), 0);
  r.views = {r.origins.views,
             r.directions.views,
             {reinterpret_cast<const char*>(r.t_max.data()), r.t_max.strides(0)}};
  return r;
}

Vec3d vector_of(const char* what, const Doubles& three) {
  const Points p = points_of(what, three);
  if (!p.shape.empty()) throw Error(std::string(what) + ": expected three numbers");
  return p.views[0];
}

py::array_t<double> array_of(Vec3d v) {
  py::array_t<double> array(3);
  for (int k = 0; k < 3; ++k) array.mutable_at(k) = v[k];
  return array;
}

py::array_t<double> array_of(const Box& box) {
  py::array_t<double> array({2, 3});
  for (int k = 0; k < 3; ++k) {
    array.mutable_at(0, k) = box.lo[k];
    array.mutable_at(1, k) = box.hi[k];
  }
  return array;
}

py::array_t<double> array_of(const Affine& map) {
  py::array_t<double> array({4, 4});
  for (int row = 0; row < 4; ++row) {
    for (int k = 0; k < 3; ++k) {
      array.mutable_at(row, k) = row < 3 ? map.m[std::size_t(row)][k] : 0;
    }
    array.mutable_at(row, 3) = row < 3 ? map.t[row] : 1;
  }
  return array;
}

Affine affine_of(const Doubles& matrix) {
  if (matrix.ndim() != 2 || matrix.shape(1) != 4 ||
      (matrix.shape(0) != 3 && matrix.shape(0) != 4)) {
    throw Error("a map has the shape " + text_of(shape_of(matrix)) + "; expected (4, 4) or (3, 4)");
  }
  for (int k = 0; k < 4 && matrix.shape(0) == 4; ++k) {
    if (matrix.at(3, k) == (k == 3 ? 1 : 0)) continue;
    throw Error(
        "the last row of a map is not 0, 0, 0, 1; columns are (i, j, k, 1), so that the "
        "shift is the last column");
  }
  Affine map;
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) map.m[std::size_t(row)][k] = matrix.at(row, k);
    map.t[row] = matrix.at(row, 3);
  }
  return map;
}

}  // namespace pvol::python
