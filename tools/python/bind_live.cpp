// pvol.Live: a picture that refines while its scene is changed.
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <utility>

#include "cli/live_picture.h"
#include "pvol/error.h"
#include "python/bind.h"
#include "python/pictures.h"
#include "python/requests.h"

namespace pvol::python {
namespace {

class Live {
 public:
  Live(const py::object& scene, const py::kwargs& settings)
      : picture_(std::make_unique<cli::LivePicture>(cli::LiveScene({"pvol", true}))) {
    change(scene, settings);
  }

  void change(const py::object& scene, const py::kwargs& settings) {
    const SceneRequest request = request_of(scene, settings);
    formats::SceneFile file = read_request(request);
    file.scene.options.count = request.count;
    cli::GivenClouds clouds = place_volumes(request, file);
    change_ = open().change(std::move(file), {.filter = request.denoise}, std::move(clouds));
  }

  /// Of this change; nothing of one before it.
  [[nodiscard]] std::optional<cli::LiveState> state() const {
    cli::LiveState s = open().state();
    if (s.change != change_) return std::nullopt;
    return s;
  }

  [[nodiscard]] std::uint64_t version() const { return open().state().number; }

  [[nodiscard]] bool wait(std::uint64_t version, double seconds) const {
    const cli::LivePicture& picture = open();
    const py::gil_scoped_release unlocked;
    return picture.wait(version, seconds).number > version;
  }

  void close() {
    const py::gil_scoped_release unlocked;
    picture_.reset();
  }

 private:
  [[nodiscard]] cli::LivePicture& open() const {
    if (!picture_) throw Error("the live picture is closed; make another one");
    return *picture_;
  }

  std::unique_ptr<cli::LivePicture> picture_;
  std::uint64_t change_ = 0;
};

std::optional<Picture> picture(const Live& live) {
  const auto state = live.state();
  return state ? picture_of(*state) : std::nullopt;
}

std::optional<std::string> error(const Live& live) {
  const auto state = live.state();
  if (!state || state->error.empty()) return std::nullopt;
  return state->error;
}

constexpr const char* kLiveText = R"(A picture that refines on threads of its own.

Takes what `render` takes. First states have fewer pixels (`picture().rgb.shape`), so that there is
something to see at once; then samples are added up to those of the scene. Clouds stay in memory
while the scene changes. All calls return at once, but for `wait`.

    with pvol.Live("scene.toml") as live:
        live.wait(0, 1)                                    # for the first state
        live.change("scene.toml", camera={"fov": 20})      # begins anew

Parameters
----------
scene, **settings
    As of `render`.)";

}  // namespace

void bind_live(py::module_& m) {
  py::class_<Live>(m, "Live", kLiveText)
      .def(py::init<const py::object&, const py::kwargs&>(), py::arg("scene"))
      .def("change", &Live::change, py::arg("scene"),
           "Begins anew with another scene and settings.")
      .def("picture", &picture, "The picture so far, or None.")
      .def_property_readonly("version", &Live::version,
                             "A number that rises with each state of the picture.")
      .def("wait", &Live::wait, py::arg("version"), py::arg("seconds"),
           "Waits for a state later than `version`; whether there is one.")
      .def_property_readonly(
          "finished",
          [](const Live& l) {
            const auto s = l.state();
            return s && s->finished;
          },
          "Whether the picture has all its samples, or failed.")
      .def_property_readonly("error", &error, "Why it failed, or None.")
      .def("close", &Live::close, "Ends the render and frees the clouds.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](Live& l, const py::args&) { l.close(); });
}

}  // namespace pvol::python
