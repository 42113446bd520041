// pvol.render and pvol.Picture.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <exception>
#include <limits>
#include <memory>

#include "python/bind.h"
#include "python/cancellable.h"
#include "python/names.h"
#include "python/pictures.h"
#include "python/requests.h"
#include "python/warn.h"

namespace pvol::python {
namespace {

/// An array (H, W, n), or (H, W) for n = 1, of number(pixel, component).
template <class Number>
py::array_t<float> image(const Film& film, int components, const Number& number) {
  Shape shape{film.crop_height, film.crop_width};
  if (components > 1) shape.push_back(components);
  auto array = new_array<float>(shape);
  float* to = array.mutable_data();
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    for (int k = 0; k < components; ++k) *to++ = float(number(i, k));
  }
  return array;
}

py::array_t<float> rgb(const Picture& p) {
  return image(p.film, 3, [&](std::size_t i, int k) { return mean(p.film.pixels[i])[k]; });
}

py::array_t<float> alpha(const Picture& p) {
  return image(p.film, 1, [&](std::size_t i, int) {
    const PixelSums& s = p.film.pixels[i];
    return s.samples ? s.alpha / s.samples : 0.0;
  });
}

py::array_t<float> standard_error(const Picture& p) {
  return image(p.film, 3, [&](std::size_t i, int k) {
    const PixelSums& s = p.film.pixels[i];
    return s.samples < 2 ? std::numeric_limits<double>::quiet_NaN()
                         : std::sqrt(variance_of_mean(s)[k]);
  });
}

py::array_t<float> samples(const Picture& p) {
  return image(p.film, 1, [&](std::size_t i, int) { return p.film.pixels[i].samples; });
}

py::array_t<float> aov(const Picture& p, const std::string& name) {
  const cli::Plane plane = layer_of(p, name);
  const auto n = std::size_t(plane.components);
  return image(p.film, plane.components,
               [&](std::size_t i, int k) { return plane.values[i * n + std::size_t(k)]; });
}

py::dict counts(const Picture& p) {
  py::dict d;
  if (!p.counted) return d;
  for (const Counter& c : kCounters) d[c.name] = value(c, p.counts);
  return d;
}

/// on_pass(picture, share) of Python, for a render without the interpreter's lock. What it raises
/// ends the render and is kept in `raised`. None goes on, as what is true does.
OnPass to_on_pass(const py::object& callable, std::exception_ptr& raised) {
  if (callable.is_none()) return {};
  return [&callable, &raised](Picture picture, std::optional<double> share) {
    const py::gil_scoped_acquire locked;
    try {
      const auto shared = std::make_shared<Picture>(std::move(picture));
      const py::object answer = callable(shared, share);
      return answer.is_none() || py::bool_(answer);  // also of NumPy's bools
    } catch (...) {
      raised = std::current_exception();
      return false;
    }
  };
}

Picture render(const py::object& scene, const py::object& on_pass, const py::kwargs& settings) {
  const SceneRequest request = request_of(scene, settings);
  std::exception_ptr raised;
  const OnPass pass = to_on_pass(on_pass, raised);
  Picture picture =
      cancellable([&](const Stop& stop) { return render_request(request, pass, stop); });
  if (raised) std::rethrow_exception(raised);
  warn(picture.warnings);
  return picture;
}

void write(const Picture& p, const std::filesystem::path& file, double exposure,
           const std::string& tone_map) {
  const py::gil_scoped_release unlocked;
  const formats::Display display{exposure, tone_map};
  formats::validate(display);
  save(p, file, display);
}

std::string repr_of_picture(const Picture& p) {
  const auto noise = pixel_noise(p.film);
  return "<pvol.Picture " + std::to_string(p.film.crop_width) + " x " +
         std::to_string(p.film.crop_height) +
         (noise ? ", noise " + number_text(float(*noise)) : "") + ">";
}

constexpr const char* kPictureText = R"(A rendered picture with its statistics.

Arrays have rows from the top; light is linear, in the colour space of the scene, and premultiplied by alpha.)";

constexpr const char* kRenderText = R"(Renders a scene by unbiased path tracing.

Parameters
----------
scene : path, dict, Volume or sequence of Volumes
    A scene file or a cloud; or a dict of the sections and keys of scene files, whose "volume" is a
    Volume, {"file": ...} or a list of these; or volumes alone, in the usual light, framed.
on_pass : callable, optional
    on_pass(picture, share) is called between passes over the picture, the first of which takes one
    sample of each pixel: with the picture so far and the share of its samples, None where that is
    not known yet. Returning False ends the render, which returns the picture so far.
**settings
    Options of the renderer by their keys (spp=64, size=(320, 240), noise=0.02, seed=1, tracker=...,
    aov=["depth"], threads=2); other sections as dicts (camera={"azimuth": 45}), which add to those of
    the scene; count=True counts the work, force=True renders scenes that would hardly end,
    denoise=True filters the noise of the picture (biased).
    `pvol-render --help` lists all options, its man page all sections.

Returns
-------
Picture
    Ctrl-C ends the render within a moment and is passed on; the picture is then lost.)";

constexpr const char* kSaveText = R"(Writes an .exr (linear, with variance and samples) or a .png.

Parameters
----------
path : path
exposure : float
    In stops; of a .png.
tone_map : str
    "srgb" (clips), "neutral", "filmic", or a view of the OCIO configuration that the environment
    variable OCIO names, such as "ACES 1.0" of the built-in one; of a .png.)";

constexpr const char* kAovText = R"(A layer, (H, W) or (H, W, 3), by its name.

What is rendered has "variance", "samples" and "transmittance"; others are requested with aov=[...]
(`pvol-render --help`). What is read has those of its file; see `layers`.)";

}  // namespace

void bind_pictures(py::module_& m) {
  py::class_<Picture, std::shared_ptr<Picture>>(m, "Picture", kPictureText)
      .def_property_readonly("rgb", &rgb, "Mean radiance, (H, W, 3).")
      .def_property_readonly("alpha", &alpha, "1 - transmittance, (H, W).")
      .def_property_readonly("error", &standard_error,
                             "Standard error of `rgb`, (H, W, 3); NaN of fewer than two samples.")
      .def_property_readonly("samples", &samples, "Camera samples of each pixel, (H, W).")
      .def_property_readonly("layers", &layer_names, "Names for `aov`.")
      .def("aov", &aov, py::arg("name"), kAovText)
      .def_property_readonly(
          "counts", &counts,
          "Total work by name; empty without count=True or counting AOVs, and of what was read.")
      .def_readonly("plan", &Picture::plan,
                    "Choices of the renderer and their reasons, one per line.")
      .def_readonly("attributes", &Picture::attributes, "Attributes in the header of an .exr.")
      .def_property_readonly(
          "color_space", [](const Picture& p) { return name(p.film.color_space); },
          "Of `rgb` and other colours, such as \"rec709\" or \"acescg\".")
      .def_property_readonly(
          "noise", [](const Picture& p) { return pixel_noise(p.film); },
          "Of pixels beside their own brightness, as `noise=` asks for it: the root mean square of "
          "their\n"
          "standard errors over that, or over 1 % of the mean where it is less. None if unknown.")
      .def("save", &write, py::arg("path"), py::arg("exposure") = 0, py::arg("tone_map") = "srgb",
           kSaveText)
      .def("__repr__", &repr_of_picture);
  m.def("render", &render, py::arg("scene"), py::kw_only(), py::arg("on_pass") = py::none(),
        kRenderText);
  m.def("tone_maps", &formats::tone_maps,
        "Names for tone_map: those of pvol, then views of the OCIO configuration.");
  m.def("read_picture", &read_picture, py::arg("path"),
        "Reads an .exr as a Picture, with the errors and layers that it has.");
}

}  // namespace pvol::python
