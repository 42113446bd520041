// pvol.Shell: bounding shells of a few hundred bytes, and their fit.
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pvol/error.h"
#include "pvol/shell/certificate.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/mesh.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/shell/recipe_support.h"
#include "python/bind.h"
#include "python/rays.h"

namespace pvol::python {
namespace {

/// A shell in the world of its volume.
struct PlacedShell {
  Shell shell;
  Affine to_world, to_index;
};

/// A span of a ray inside the shell.
struct SpanRow {
  std::int64_t ray;
  double t0, t1;
};

PlacedShell placed(Shell shell, const CloudVolume& v) {
  const Affine to_world = index_to_world(v);
  return {std::move(shell), to_world, inverse(to_world)};
}

std::optional<PlacedShell> shell_of(const CloudVolume& v) {
  if (!v.cloud->shell) return std::nullopt;
  return placed(*v.cloud->shell, v);
}

Support support_of(const formats::Cloud& cloud) {
  return cloud.recipe() ? make_support(*cloud.recipe()) : make_support(cloud.grid(), cloud.pyramid);
}

ShellKind kind_of(const std::string& word) {
  if (word == "hard") return ShellKind::hard;
  if (word == "soft") return ShellKind::soft;
  throw Error("kind: found '" + word + "', expected hard or soft");
}

PlacedShell fit(const CloudVolume& v, const std::string& kind, std::optional<int> perturbations,
                int effort) {
  ShellOptions o{.kind = kind_of(kind), .perturbations = perturbations, .effort = effort};
  o.index_to_world = index_to_world(v);
  struct Stopped {};
  return cancellable([&](const Stop& stop) {
    try {
      return placed(fit_shell(support_of(*v.cloud), o,
                              [&](std::uint64_t, std::uint64_t) {
                                if (stop) throw Stopped{};
                              }),
                    v);
    } catch (const Stopped&) {
      return PlacedShell{};  // nobody sees it
    }
  });
}

py::array_t<bool> contains(const PlacedShell& s, const Doubles& array) {
  const Points points = points_of("points", array);
  auto inside = new_array<bool>(points.shape);
  bool* to = inside.mutable_data();
  run_cancellable([&](const Stop& stop) {
    for_each_part(points.views.count, kPart, stop, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        to[i] = pvol::contains(s.shell, s.to_index.point(points.views[i]));
      }
    });
  });
  return inside;
}

/// In cells a direction of the world has another length; t counts world units of a unit direction.
Ray to_cells(const PlacedShell& s, const Ray& ray) {
  const double size = length(ray.d);
  if (!(is_finite(ray.o) && size > 0 && std::isfinite(size))) {
    throw Error("a ray is not finite or has no direction");
  }
  return {s.to_index.point(ray.o), s.to_index.vector(ray.d / size)};
}

py::array_t<SpanRow> intersect(const PlacedShell& s, const Doubles& origins,
                               const Doubles& directions, const Doubles& t_max) {
  const Rays rays = rays_of(origins, directions, t_max);
  std::vector<SpanRow> rows;
  {
    const py::gil_scoped_release unlocked;
    const RayShell evaluator(s.shell);
    std::vector<Span> spans;
    for (std::size_t i = 0; i < rays.views.count(); ++i) {
      evaluator.intersect(to_cells(s, rays.views[i]), 0, rays.views.t_max[i], spans);
      for (const Span& span : spans) rows.push_back({std::int64_t(i), span.t0, span.t1});
    }
  }
  return array_of(rows);
}

py::tuple mesh(const PlacedShell& s, int resolution) {
  TriangleMesh made = cancellable([&](const Stop&) { return make_mesh(s.shell, resolution); });
  const bool mirrored = determinant(s.to_world) < 0;
  py::array_t<double> vertices({py::ssize_t(made.vertices.size()), py::ssize_t(3)});
  py::array_t<std::uint32_t> faces({py::ssize_t(made.triangles.size()), py::ssize_t(3)});
  auto v = vertices.mutable_unchecked<2>();
  auto f = faces.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < v.shape(0); ++i) {
    const Vec3d p = s.to_world.point(made.vertices[std::size_t(i)]);
    for (int k = 0; k < 3; ++k) v(i, k) = p[k];
  }
  for (py::ssize_t i = 0; i < f.shape(0); ++i) {
    for (int k = 0; k < 3; ++k) {
      f(i, k) = made.triangles[std::size_t(i)][std::size_t(mirrored ? 2 - k : k)];
    }
  }
  return py::make_tuple(std::move(vertices), std::move(faces));
}

py::array_t<double> terms_of(const PlacedShell& s) {
  const auto& others = s.shell.form.perturbations;
  py::array_t<double> rows({py::ssize_t(1 + others.size()), py::ssize_t(10)});
  for (std::size_t i = 0; i <= others.size(); ++i) {
    const QuadricTerms t = terms(i == 0 ? s.shell.form.base : others[i - 1].form.base);
    for (std::size_t k = 0; k < t.size(); ++k) rows.mutable_at(i, k) = t[k];
  }
  return rows;
}

py::array_t<double> strengths_of(const PlacedShell& s) {
  std::vector<double> all;
  for (const Perturbation& p : s.shell.form.perturbations) all.push_back(p.strength);
  return array_of(all);
}

py::dict certificate_of(const PlacedShell& s) {
  py::dict d;
  d["bound"] = s.shell.certificate.bound;
  d["boxes"] = s.shell.certificate.boxes;
  d["depth"] = s.shell.certificate.depth;
  d["margin"] = evaluator_margin(s.shell);
  return d;
}

py::dict tightness_of(const PlacedShell& s) {
  py::dict d;
  d["volume_ratio"] = s.shell.tightness.volume_ratio;
  d["hit_ratio"] = s.shell.tightness.hit_ratio;
  d["box_volume_ratio"] = s.shell.tightness.box_volume_ratio;
  d["box_hit_ratio"] = s.shell.tightness.box_hit_ratio;
  return d;
}

/// The map of p = scale * (index - centre), in which the quadrics are written, (4, 4).
py::array_t<double> frame_of(const PlacedShell& s) {
  const ShellFrame f = frame(s.shell);
  return array_of(scaling(Vec3d(1 / f.unit)) * translation(-f.centre) * s.to_index);
}

constexpr const char* kShellText =
    R"(A closed region of a few hundred bytes that contains every occupied cell.

Made by `fit_shell`, or read with a .pvol file (`Volume.shell`). Inside its box it is where
F(p) >= 0, with perturbations that bulge or dent it: of hard shells by union and difference, of soft
ones by F'(p) = F(p) + sum_i a_i max(0, Q_i(p))^2 >= 0.)";

constexpr const char* kFitText =
    R"(Fits a shell around a volume, and proves that the shell contains it.

Parameters
----------
volume : Volume
kind : str
    "hard" (rays meet it in roots of quadratics) or "soft" (a smooth surface, quartics).
perturbations : int, optional
    Number of perturbations. Default: the number at which rays cost least.
effort : int
    1 to 10: more tries.

Returns
-------
Shell
    Deterministic. `volume.with_shell(shell)` renders with it.)";

constexpr const char* kIntersectText = R"(Where rays are inside.

Parameters
----------
origins, directions : array (..., 3)
t_max : float or array (...)

Returns
-------
structured array
    "ray" (number of the ray, counted through the leading axes), "t0", "t1" (world units): ascending
    and apart for each ray. They contain every t at which the ray is inside.)";

}  // namespace

void bind_shells(py::module_& m, VolumeClass& volume) {
  PYBIND11_NUMPY_DTYPE(SpanRow, ray, t0, t1);
  const double endless = std::numeric_limits<double>::infinity();
  py::class_<PlacedShell, std::shared_ptr<PlacedShell>>(m, "Shell", kShellText)
      .def_property_readonly(
          "kind",
          [](const PlacedShell& s) { return s.shell.kind == ShellKind::hard ? "hard" : "soft"; },
          "\"hard\" or \"soft\".")
      .def_property_readonly("quadrics", &terms_of,
                             "Coefficients of x^2, y^2, z^2, yz, zx, xy, x, y, z and 1, "
                             "(1 + n, 10): the base, then the perturbations.")
      .def_property_readonly("strengths", &strengths_of,
                             "Of the perturbations, (n,): above 0 bulges, below dents.")
      .def_property_readonly(
          "world_to_frame", &frame_of,
          "The map of columns (x, y, z, 1) to the space of the quadrics, (4, 4).")
      .def_property_readonly("certificate", &certificate_of,
                             "The proof: least slack over all occupied cells, and the one needed.")
      .def_property_readonly(
          "tightness", &tightness_of,
          "Volume and number of rays that hit, over those of the occupied cells.")
      .def("contains", &contains, py::arg("points"),
           "Whether points (..., 3) of the world are in it.")
      .def("intersect", &intersect, py::arg("origins"), py::arg("directions"),
           py::arg("t_max") = endless, kIntersectText)
      .def("mesh", &mesh, py::arg("resolution") = 128,
           "Its surface as (vertices (V, 3) of the world, faces (F, 3)), counter-clockwise from "
           "outside; resolution is steps along the longest side, 8 to 1024.");
  volume.def_property_readonly("shell", &shell_of, "The shell around it, or None.")
      .def(
          "with_shell",
          [](const CloudVolume& v, const PlacedShell* s) {
            return with_shell(v, s ? std::optional(s->shell) : std::nullopt);
          },
          py::arg("shell"), "The same volume with a shell that was fitted to it, or without one.");
  m.def("fit_shell", &fit, py::arg("volume"), py::arg("kind") = "hard",
        py::arg("perturbations") = py::none(), py::arg("effort") = 1, kFitText);
}

}  // namespace pvol::python
