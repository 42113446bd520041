// Scenes as text.
#include <fmt/format.h>

#include "pvol/formats/scene_file.h"
#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

/// A line for each key that scenes have and that has a value.
std::string lines(const Entries& entries) {
  std::string text;
  for (const Entry& e : entries) {
    const Value value = e.value();
    if (!e.about.in_scenes || value.nothing()) continue;
    text += fmt::format("{} = {}\n", e.about.key, toml_text(value));
  }
  return text;
}

/// A matrix; what moves as it was said, which tells how it turns.
Placement placement_of(const Affine& map, const std::optional<MovingPlacement>& moving) {
  if (moving) return moving->from;
  Placement placement;
  placement.matrix = map;
  return placement;
}

std::string to_text(const std::string& name, const std::optional<MovingPlacement>& moving) {
  if (!moving) return "";
  Placement to = moving->to;
  return fmt::format("\n[{}.to]\n", name) + lines(entries(to));
}

/// Where the volume is a frame later, and its instances.
std::string place_text(const SceneVolume& v) {
  std::string text = to_text("volume", v.moving);
  for (std::size_t i = 0; i < v.instances.size(); ++i) {
    const auto moving =
        i < v.moving_instances.size() ? v.moving_instances[i] : std::optional<MovingPlacement>{};
    Placement placement = placement_of(v.instances[i], moving);
    text += "\n[[volume.instance]]\n" + lines(entries(placement));
    text += to_text("volume.instance", moving);
  }
  return text;
}

/// Where a surface is a frame later.
std::string way_text(const Surface& surface) {
  const auto text = [&](const auto& s) -> std::string {
    if constexpr (requires { s.to; }) {
      if (s.to) return fmt::format("\n[{}.to]\n", kind_name(surface)) + lines(entries(*s.to));
    }
    return "";
  };
  return std::visit(text, surface);
}

/// The first component is what the medium's table itself describes; its share follows from theirs.
std::string medium_text(const SceneVolume& v, const std::string& name) {
  const std::vector<Component>& all = v.medium.components;
  Placement placement = placement_of(v.object_to_world, v.moving);
  std::string text = fmt::format("\n[{}]\n", name);
  const Entries medium = entries(v.medium);
  text += lines(v.has_extinction ? medium : without(medium, "extinction"));
  text += lines(without(entries(all.front()), "share")) + lines(entries(placement));
  for (std::size_t i = 1; i < all.size(); ++i) {
    text += fmt::format("\n[[{}.component]]\n", name) + lines(entries(all[i]));
  }
  if (!v.density_map.is_identity()) {
    text += fmt::format("\n[{}.density]\n", name) + lines(entries(v.density_map));
  }
  if (v.fire) {
    const Entries fire = entries(*v.fire);
    text += fmt::format("\n[{}.fire]\n", name) +
            lines(v.has_intensity ? fire : without(fire, "intensity"));
  }
  if (v.albedo_field) {
    text += fmt::format("\n[{}.albedo_field]\n", name) + lines(entries(*v.albedo_field));
  }
  if (v.velocity) text += fmt::format("\n[{}.motion]\n", name) + lines(entries(*v.velocity));
  return text;
}

}  // namespace

std::string to_toml(const SceneFile& file) {
  const Scene& scene = file.scene;
  const SceneVolume& first = file.volumes.front();
  std::string text = file.volumes.size() == 1 ? "[volume]\n" : "[[volume]]\n";
  text += lines(entries(first)) + place_text(first);
  for (std::size_t i = 1; i < file.volumes.size(); ++i) {
    const SceneVolume& v = file.volumes[i];
    text += "\n[[volume]]\n" + lines(entries(v)) + place_text(v) + medium_text(v, "volume.medium");
  }
  if (file.has_camera) {
    Entries all = entries(scene.camera);
    for (const char* key : {"azimuth", "elevation", "zoom"}) all = without(std::move(all), key);
    text += "\n[camera]\n" + lines(all);
    if (scene.camera.to) text += "\n[camera.to]\n" + lines(entries(*scene.camera.to));
  } else if (scene.camera != Camera{}) {  // what a frame keeps
    text += "\n[camera]\n" + lines(without(without(entries(scene.camera), "position"), "target"));
  }
  text += medium_text(first, "medium");
  text += fmt::format("\n[environment]\ntype = {}\n", toml_string(kind_name(scene.environment)));
  text += lines(entries(scene.environment));
  for (const Light& light : scene.lights) {
    text += fmt::format("\n[[{}]]\n", kind_name(light)) + lines(entries(light));
  }
  for (const Surface& surface : scene.surfaces) {
    text += fmt::format("\n[[{}]]\n", kind_name(surface)) + lines(entries(surface));
    text += way_text(surface);
  }
  return text + "\n[render]\n" + lines(entries(scene.options)) +
         (file.density ? lines(entries(file.density)) : "");
}

}  // namespace pvol::formats
