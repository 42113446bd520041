#include "python/requests.h"

#include <pybind11/stl/filesystem.h>

#include <memory>

#include "pvol/error.h"
#include "python/toml_words.h"

namespace pvol::python {
namespace {

namespace py = pybind11;
using Shared = std::shared_ptr<CloudVolume>;

bool is_volume(py::handle v) { return py::isinstance<CloudVolume>(v); }

bool glows(const CloudVolume& v) {
  for (const Component& c : v.given.medium.components) {
    if (c.emission != Rgb(0.0f)) return true;
  }
  return false;
}

[[noreturn]] void refuse_type(py::handle found) {
  throw py::type_error("found a " + type_name(found) +
                       ", expected a scene: the name of a file, a dict, a Volume or several");
}

/// The table of a volume: of one in memory its name alone.
py::dict table_of(py::handle volume, SceneRequest& to) {
  if (!is_volume(volume)) {
    if (!py::isinstance<py::dict>(volume)) refuse_type(volume);
    py::dict table = volume.cast<py::dict>();
    const bool inside = table.contains("file") && is_volume(table["file"]);
    to.in_memory.push_back(inside ? table["file"].cast<Shared>() : nullptr);
    if (!inside) return table;
    table = table.attr("copy")();
    table["file"] = to.in_memory.back()->given.file.string();
    return table;
  }
  to.in_memory.push_back(volume.cast<Shared>());
  py::dict table;
  table["file"] = to.in_memory.back()->given.file.string();
  return table;
}

/// The volumes of a scene as tables.
py::list tables_of(const py::object& volumes, SceneRequest& to) {
  py::list tables;
  if (is_volume(volumes) || py::isinstance<py::dict>(volumes)) {
    tables.append(table_of(volumes, to));
    return tables;
  }
  if (!py::isinstance<py::list>(volumes) && !py::isinstance<py::tuple>(volumes)) {
    refuse_type(volumes);
  }
  for (const py::handle v : volumes) tables.append(table_of(v, to));
  return tables;
}

void refuse_second_medium(const py::dict& scene, const SceneRequest& request) {
  if (!scene.contains("medium") || request.in_memory.empty() || !request.in_memory.front()) return;
  throw Error(
      "medium: a volume in memory has its own medium; change it with volume.with_medium(...)");
}

/// The text of a scene, section by section.
void write_text(py::dict scene, SceneRequest& to) {
  if (!scene.contains("volume"))
    throw Error("a scene needs a \"volume\": a Volume, or {\"file\": ...}");
  scene["volume"] = tables_of(scene["volume"], to);
  refuse_second_medium(scene, to);
  if (!to.in_memory.empty() && to.in_memory.front() && glows(*to.in_memory.front())) {
    py::dict medium;  // a scene that glows needs no sun
    medium["emission"] = 1;
    scene["medium"] = medium;
  }
  for (const auto& [key, value] : scene) {
    if (!value.is_none()) to.text += std::string(py::str(key)) + " = " + toml_text(value) + '\n';
  }
}

/// Sections are dicts, and sequences of them, as [[sun]] is; options stand by themselves.
bool is_section(py::handle value) {
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) {
    return py::isinstance<py::dict>(value);
  }
  const auto items = value.cast<py::sequence>();
  return items.size() > 0 && py::isinstance<py::dict>(items[0]);
}

/// What a setting that is no option of the renderer sets, or null.
bool* flag_of(const std::string& name, SceneRequest& to) {
  if (name == "count") return &to.count;
  if (name == "force") return &to.force;
  return name == "denoise" ? &to.denoise : nullptr;
}

/// Notes options, and returns sections.
py::dict write_options(const py::dict& settings, SceneRequest& to) {
  py::dict options, sections;
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    if (bool* const flag = flag_of(name, to)) {
      *flag = value.cast<bool>();
    } else {
      (is_section(value) ? sections : options)[key] = value;
    }
  }
  add_words("render.", options, to.settings);
  return sections;
}

/// The scene with further sections: keys of theirs replace or add to what it says.
py::dict joined(const py::dict& scene, const py::dict& sections) {
  py::dict all = scene.attr("copy")();
  for (const auto& [key, value] : sections) {
    const bool both =
        all.contains(key) && py::isinstance<py::dict>(all[key]) && py::isinstance<py::dict>(value);
    if (!both) {
      all[key] = value;
      continue;
    }
    py::dict section = all[key].attr("copy")();
    section.attr("update")(value);
    all[key] = section;
  }
  return all;
}

}  // namespace

SceneRequest request_of(const py::object& scene, const py::kwargs& settings) {
  SceneRequest request;
  const py::dict sections = write_options(settings, request);
  if (py::isinstance<py::str>(scene) || py::hasattr(scene, "__fspath__")) {
    request.file = scene.cast<std::filesystem::path>();
    add_words("", sections, request.settings);
  } else if (py::isinstance<py::dict>(scene)) {
    write_text(joined(scene.cast<py::dict>(), sections), request);
  } else {
    py::dict volumes;
    volumes["volume"] = scene;
    write_text(joined(volumes, sections), request);
  }
  return request;
}

}  // namespace pvol::python
