#include "toml/scene_keys.h"

#include <algorithm>

#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

/// The default of an entry as TOML, or in the words that its row has for it.
std::string otherwise_text(const Entry& e) {
  if (*e.about.otherwise != 0) return e.about.otherwise;
  if (e.about.required) return "";
  const Value value = e.value();
  return value.nothing() ? "" : toml_text(value);
}

/// A section with the keys of a thing that has its defaults.
SectionManual section(const std::string& heading, const std::string& about,
                      const Entries& entries) {
  SectionManual manual{heading, about, {}};
  for (const Entry& e : entries) {
    if (!e.about.in_scenes) continue;
    manual.lines.push_back(
        {e.about.key, e.about.help, expected(e.about.limits), otherwise_text(e)});
  }
  return manual;
}

/// A component with every kind of phase function in turn: the keys of all.
Entries all_component_keys(std::vector<Component>& storage) {
  Entries all;
  const auto kinds = all_kinds<PhaseFunction>();
  storage.resize(kinds.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (i > 0) storage[i].phase = kinds[i];
    for (const Entry& e : entries(storage[i])) {
      if (!find_key(all, e.about.key)) all.push_back(e);
    }
  }
  return all;
}

}  // namespace

std::vector<std::string_view> section_names() {
  std::vector<std::string_view> names{"volume", "world", "camera", "medium", "environment"};
  static const std::vector<Light> kinds = all_kinds<Light>();
  for (const Light& kind : kinds) names.emplace_back(kind_name(kind));
  static const std::vector<Surface> surfaces = all_kinds<Surface>();
  for (const Surface& kind : surfaces) names.emplace_back(kind_name(kind));
  names.emplace_back("render");
  return names;
}

Entries render_keys(SceneFile& file) {
  // The density's come before those that only measurements and previews need.
  Entries all = entries(file.scene.options);
  const Entries density = entries(file.density);
  const auto place = std::find_if(all.begin(), all.end(), [](const Entry& e) {
    return std::string_view(e.about.key) == "majorant_scale";
  });
  all.insert(place, density.begin(), density.end());
  return all;
}

std::vector<SectionManual> describe_sections() {
  // The tolerance has a default where the precision is one that has a tolerance.
  SceneFile file{.volumes = {SceneVolume{}}, .density = Quantisation{.precision = Precision::fpn}};
  std::vector<Component> components;
  Placement placement;
  const Entries component = all_component_keys(components);
  std::vector<SectionManual> all;
  all.push_back(section("[volume]",
                        "The cloud. Several clouds, which may overlap, have a [[volume]] each.",
                        entries(file.volumes.front())));
  all.push_back(
      section("[[volume.instance]]",
              "A further placement of the volume, applied after that of its medium. The volume "
              "appears once for each instance, or once without any; all share its data.",
              entries(placement)));
  all.push_back(section("[volume.to]",
                        "The placement of the volume one frame later: the medium's placement moves "
                        "there evenly while the camera's shutter is open. Instances have a `to = "
                        "{...}` for this. Keys left out keep their values.",
                        entries(placement)));
  World world;
  all.push_back(section("[world]", "The orientation of the scene.", entries(world)));
  all.push_back(section("[camera]", "Without position and target the camera frames the clouds.",
                        entries(file.scene.camera)));
  CameraPlace to;
  all.push_back(section("[camera.to]",
                        "The place of the camera one frame later: it moves there evenly while the "
                        "shutter is open. Keys left out keep their values.",
                        entries(to)));
  all.push_back(
      section("[medium]",
              "The medium of the first volume, and its placement; each further volume has a "
              "[volume.medium].",
              joined(joined(entries(file.volumes.front().medium), without(component, "share")),
                     entries(placement))));
  all.push_back(section("[[medium.component]]",
                        "Another component of the medium in the same cloud.", component));
  FieldMap map;
  all.push_back(section(
      "[medium.density]",
      "A map from the grid's values to the density, after interpolation; it must map 0 to 0.",
      entries(map)));
  Fire fire;
  all.push_back(section("[medium.fire]",
                        "Emission by a grid of the file, with or without a density.",
                        entries(fire)));
  AlbedoMap albedo;
  all.push_back(section("[medium.albedo_field]",
                        "A grid of the file by which the albedo of every component is multiplied; "
                        "grids of colours with common names need no such section.",
                        entries(albedo)));
  VelocityChoice velocity;
  all.push_back(section("[medium.motion]",
                        "The motion of the cloud while the camera's shutter is open; velocities "
                        "with common names need no such section.",
                        entries(velocity)));
  for (Environment& sky : all_kinds<Environment>()) {
    const std::string type = kind_name(sky);
    all.push_back(section("[environment] type = \"" + type + "\"", "", entries(sky)));
  }
  for (Light& light : all_kinds<Light>()) {
    all.push_back(section(std::string("[[") + kind_name(light) + "]]", "", entries(light)));
  }
  for (Surface& surface : all_kinds<Surface>()) {
    all.push_back(section(std::string("[[") + kind_name(surface) + "]]", "", entries(surface)));
  }
  BallPlace ball;
  all.push_back(section("[ball.to]",
                        "The place of the ball one frame later: it moves there evenly while the "
                        "camera's shutter is open.",
                        entries(ball)));
  all.push_back(section("[mesh.to]",
                        "The placement of the mesh one frame later; of a solid in [solid.to]. Keys "
                        "left out keep their values.",
                        entries(placement)));
  all.push_back(section("[render]", "Options of the renderer; the command line has the same.",
                        render_keys(file)));
  return all;
}

}  // namespace pvol::formats
