// pvol.Live: a picture that refines while its scene is changed.
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
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
      : picture_(std::make_shared<cli::LivePicture>(cli::LiveScene({"pvol", true}))) {
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
    if (!s.error.empty() && !s.job) s.film.reset();  // that of a change before
    return s;
  }

  [[nodiscard]] std::uint64_t version() const { return open().state().number; }

  /// In short waits, between which Python looks after signals.
  [[nodiscard]] bool wait(std::uint64_t version, double seconds) const {
    constexpr double kShort = 0.05;
    const std::shared_ptr<cli::LivePicture> picture = shared();  // others may close it meanwhile
    const auto begin = std::chrono::steady_clock::now();
    for (;;) {
      const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
      const double left = seconds - waited.count();
      bool is_newer = false;
      {
        const py::gil_scoped_release unlocked;
        is_newer = picture->wait(version, std::clamp(left, 0.0, kShort)).number > version;
      }
      if (is_newer) return true;
      if (!(left > 0)) return false;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
  }

  void close() {
    std::shared_ptr<cli::LivePicture> last = std::move(picture_);
    const py::gil_scoped_release unlocked;
    last.reset();
  }

 private:
  [[nodiscard]] std::shared_ptr<cli::LivePicture> shared() const {
    if (!picture_) throw Error("the live picture is closed; make another one");
    return picture_;
  }
  [[nodiscard]] cli::LivePicture& open() const { return *shared(); }

  std::shared_ptr<cli::LivePicture> picture_;
  std::uint64_t change_ = 0;
};

std::optional<Picture> picture(const Live& live) {
  const auto state = live.state();
  return state ? picture_of(*state) : std::nullopt;
}

std::optional<std::string> failure(const Live& live) {
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
      .def_property_readonly("error", &failure, "Why it failed, or None.")
      .def("close", &Live::close, "Ends the render and frees the clouds.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](Live& l, const py::args&) { l.close(); });
}

}  // namespace pvol::python
